"""Progress of a run: its phases, its fractions, and its end by the caller."""

import pytest

from adaptive_fairing.core.denoising.progress import SHARE_OF_ROUND, ProgressReport

ROUNDS = [("filter", number) for number in range(1, len(SHARE_OF_ROUND) + 1)]
PHASES = [("noise", 0), *ROUNDS, ("mix", 0), ("measure", 0)]


def told(*, has_plan):
    seen = []
    report = ProgressReport(seen.append, has_plan=has_plan)
    for phase in PHASES:
        report.begin(*phase)
        report.again()
    report.finish()
    return seen


@pytest.mark.parametrize("has_plan", [False, True])
def test_every_phase_goes_on_where_the_last_one_ended(has_plan):
    *running, end = told(has_plan=has_plan)
    assert running[::2] == running[1::2]
    phases = running[::2]
    assert [each[:2] for each in phases] == PHASES
    assert {each.total for each in phases if each.number} == {len(SHARE_OF_ROUND)}
    begins = [each.fraction_done for each in phases]
    assert begins[0] == 0
    assert [each.fraction_at_end for each in phases] == pytest.approx([*begins[1:], 1])
    assert (end.fraction_done, end.fraction_at_end) == (1, 1)


def test_with_a_plan_the_noise_takes_no_time_and_the_rounds_keep_their_proportions():
    without, planned = (told(has_plan=each)[:-1:2] for each in (False, True))
    assert planned[0].fraction_at_end == 0 < without[0].fraction_at_end
    shares = [
        [each.fraction_at_end - each.fraction_done for each in phases[1:]]
        for phases in (without, planned)
    ]
    ratios = [plan / own for own, plan in zip(*shares, strict=True)]
    assert ratios == pytest.approx([1 / (1 - without[0].fraction_at_end)] * len(ratios))


def test_the_caller_may_end_the_run_and_need_not_listen():
    def cancel(progress):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        ProgressReport(cancel, has_plan=False).begin("noise")
    ProgressReport(None, has_plan=False).begin("noise")
