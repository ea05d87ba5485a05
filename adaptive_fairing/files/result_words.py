"""What a result is called: after the algorithm that made it, in names of files and objects."""

DENOISED, FAIRED, REFINED = "denoised", "faired", "refined"
