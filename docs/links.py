"""Checks the links of a site that docs/build.sh has built: files and headings. Prints broken links, and fails if there are any."""

import sys
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit


class Page(HTMLParser):
    """The links of a page and the names that links may lead to."""

    def __init__(self, path: Path) -> None:
        super().__init__()
        self.links: list[str] = []
        self.names: set[str] = set()
        self.feed(path.read_text(encoding="utf-8"))

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        for key, value in attrs:
            if key in ("href", "src") and value:
                self.links.append(value)
            if key in ("id", "name") and value:
                self.names.add(value)


def main(site: Path) -> int:
    book = [path for path in site.glob("book/**/*.html") if path.name not in ("print.html", "404.html", "toc.html")]
    pages = {path.resolve(): Page(path) for path in [site / "index.html", *book]}
    broken, checked = [], 0
    for path, page in pages.items():
        for link in page.links:
            parts = urlsplit(link)
            if parts.scheme or parts.netloc:
                continue
            checked += 1
            target = (path.parent / unquote(parts.path)).resolve() if parts.path else path
            target = target / "index.html" if target.is_dir() else target
            names = pages[target].names if target in pages else None
            if not target.exists() or (parts.fragment and names is not None and unquote(parts.fragment) not in names):
                broken.append(f"{path.relative_to(site)}: {link}")
    print("\n".join(sorted(set(broken)) + [f"{checked} links on {len(pages)} pages, {len(broken)} broken"]))
    return 1 if broken or len(pages) < 2 else 0


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1]).resolve()))
