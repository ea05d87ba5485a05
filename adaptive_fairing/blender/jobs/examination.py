"""Examination of a mesh as a job beside Blender's window, like a solve but without a result.

No bpy, so that it can run in a thread.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from ...core import FairingError
from ...core.denoising.examination import Examination, examine
from ...core.denoising.progress import DenoiseProgress
from .solve import Solve


@dataclass
class ExaminationJob(Solve):
    """One mesh, and the findings of its examination.

    Attributes
    ----------
    found
        Findings; None until the end, and after a `failure`.
    """

    found: Examination | None = None

    @property
    def is_over(self) -> bool:
        """Whether the job has ended."""
        return self.found is not None or self.failure is not None

    def run(self) -> Iterator[Solve]:
        """Examine the mesh; yield this object once it is done.  Raises: as `Solve.run`."""
        try:
            self.found = examine(
                self.vertices, self.triangles, self.settings, progress=self.note_progress
            )
        except (FairingError, MemoryError) as error:
            self.failure = error
        else:
            yield self

    def note_progress(self, progress: DenoiseProgress) -> None:
        """Note the progress; in a run this would be the first phase only."""
        super().note_progress(progress._replace(fraction_at_end=1.0))
