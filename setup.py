"""The description of the package for indexes, which show neither pictures nor links of a folder."""

import re
from pathlib import Path

from setuptools import setup

HERE = r"(?!https?:)[^)]*"  # an address within the repository

text = (Path(__file__).parent / "README.md").read_text(encoding="utf-8")
text = re.sub(rf"!\[[^\]]*\]\({HERE}\)\n*", "", text)
text = re.sub(rf"\[([^\]]*)\]\({HERE}\)", r"\1", text)
setup(long_description=text, long_description_content_type="text/markdown")
