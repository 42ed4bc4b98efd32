"""Each control of the page has a name to be read aloud, and a page asked for little motion does not start by itself."""

from html.parser import HTMLParser
from importlib.resources import files

ASSETS = files("warpmuscle.view") / "assets"
CONTROLS = ("button", "select", "input", "textarea", "canvas", "dialog", "nav")
EMPTY = ("input", "meta")  # elements without an end


class Names(HTMLParser):
    """Collects controls with what they are called: by themselves, or by the label around them."""

    def __init__(self) -> None:
        super().__init__()
        self.open: list[dict[str, str]] = []
        self.found: dict[str, str] = {}

    def handle_starttag(self, tag, attrs):
        given = {name: value or "" for name, value in attrs}
        given |= {"tag": tag, "said": given.get("aria-label", "") or given.get("aria-labelledby", "")}
        if tag in CONTROLS and any(one["tag"] == "label" for one in self.open):
            given["said"] = given["said"] or "label"
        self.open.append(given)
        if tag in EMPTY:
            self.close_one(tag)

    def handle_data(self, data):
        if self.open and self.open[-1]["tag"] == "button" and any(letter.isalnum() for letter in data):
            self.open[-1]["said"] = self.open[-1]["said"] or data

    def handle_endtag(self, tag):
        self.close_one(tag)

    def close_one(self, tag):
        while self.open:
            last = self.open.pop()
            if last["tag"] in CONTROLS:
                self.found[f"{last['tag']} {last.get('id', len(self.found))}"] = last["said"]
            if last["tag"] == tag:
                return


def test_each_control_has_a_name_in_words():
    names = Names()
    names.feed((ASSETS / "page.html").read_text(encoding="utf-8"))
    assert len(names.found) > 20
    assert [control for control, said in names.found.items() if not said] == []
    assert names.found["button play"] == "play"


def test_a_page_waits_for_whoever_asks_for_little_motion():
    player = (ASSETS / "player.js").read_text(encoding="utf-8")
    assert 'matchMedia("(prefers-reduced-motion: reduce)")' in player
    assert "content.autoplay && (Boolean(content.live) || !calm())" in player
