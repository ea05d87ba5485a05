"""The benchmark of refinement: that both sides make what they are said to make."""

import pytest

pytest.importorskip("bpy")

from benchmarks import refinement


def test_it_prints_a_table_for_meshes_with_as_many_faces(capsys, monkeypatch):
    monkeypatch.setattr("sys.argv", ["refinement", "--faces", "800", "--repeats", "1"])
    refinement.main()
    tables = capsys.readouterr().out.split("UV map")[1:]
    assert len(tables) == 2
    for text in tables:
        rows = [line.split("|")[1:-1] for line in text.splitlines() if line.startswith("|")][2:]
        faces = [int(row[1].replace(",", "")) for row in rows]
        assert len(faces) == 4
        assert max(faces) < 1.05 * min(faces)
        assert rows[0][0].strip() == refinement.MODIFIER and float(rows[0][4]) == 1.0
