# SPDX-License-Identifier: MIT OR Apache-2.0
"""The blocks of docs/python.md run, one after the other."""
import re
from pathlib import Path

GUIDE = Path(__file__).parents[2] / "docs" / "python.md"


def test_every_block_runs(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    text = GUIDE.read_text()
    blocks = list(re.finditer(r"^```python\n(.*?)^```$", text, re.M | re.S))
    assert len(blocks) >= 6
    names = {}
    for block in blocks:
        line = text[: block.start(1)].count("\n")
        exec(compile("\n" * line + block.group(1), str(GUIDE), "exec"), names)
    printed = capsys.readouterr().out
    assert "Mixture(effective_modulus=" in printed and "2000 1 [0.00375" in printed
