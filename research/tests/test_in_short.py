"""The short table, which README has: which parameters count, and how meshes are put together."""

from types import SimpleNamespace

from research.denoising.peers import Peer
from research.denoising.tables import in_short


def entry(noisy, own, scores):
    def score(mean, angle, seconds):
        return {"mean": mean, "angle": angle, "seconds": seconds}

    return SimpleNamespace(
        noisy={"mean": noisy, "angle": 30.0},
        ours=score(*own),
        peers={name: {key: score(*each) for key, each in found.items()} for name, found in scores},
    )


def test_errors_and_times_have_geometric_means_and_angles_plain_ones():
    tuned = Peer("tuned", (), "n", (1, 2), run=None)
    fixed = Peer("fixed", (), "n", (1, 2), run=None, published="n 1")
    # Of the one the better parameter counts, of the other the published one.
    scores = {"n 1": (0.4, 8.0, 4.0), "n 2": (0.1, 2.0, 1.0)}
    entries = [
        entry(0.2, (0.1, 1.0, 2.0), [("tuned", scores), ("fixed", scores)]),
        entry(0.8, (0.4, 3.0, 8.0), [("tuned", scores), ("fixed", scores)]),
    ]
    rows = [
        [cell.strip() for cell in line.strip("|").split("|")]
        for line in in_short(entries, [tuned, fixed]).splitlines()
    ]
    assert rows[2:] == [
        ["noisy", "", "0.400", "30.0°", ""],
        ["tuned", "best for each mesh", "0.100", "2.0°", "0.25"],
        ["fixed", "published: n 1", "0.400", "8.0°", "1"],
        ["Denoise", "none", "0.200", "2.0°", "1"],
    ]
