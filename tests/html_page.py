"""What a page of HTML holds, for tests of pages."""

from html.parser import HTMLParser


class Page(HTMLParser):
    """Texts and references of a page, and whether its elements are closed in order."""

    VOID = ("meta", "img", "link", "br", "input", "hr")

    def __init__(self, text: str) -> None:
        super().__init__()
        self.open, self.texts, self.links, self.ids = [], [], [], []
        self.feed(text)

    def handle_starttag(self, tag, attributes):
        if tag not in self.VOID:
            self.open.append(tag)
        self.links += [value for name, value in attributes if name in ("src", "href")]
        self.ids += [value for name, value in attributes if name == "id"]

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        self.texts.append(data.strip())
