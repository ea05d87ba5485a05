"""Words for results in names of files and objects, by the algorithm that made them."""

DENOISED, FAIRED, REFINED = "denoised", "faired", "refined"
