"""Benchmark of denoising: our methods and the smoothers in use, against clean surfaces.

`python -m research.denoising --help` shows the one command. The modules, from the data up:
`shapes` makes clean meshes, `noise` spoils them, `pairs` gives clean and noisy meshes by name,
`measures` says how far a result is from the clean surface, `peers` and `ours` are the contestants,
`contest` runs them and keeps what does not change, `tables` and `pictures` show the outcome.
"""
