#!/usr/bin/env python3
"""Writes docs/options.md from the program's manual page:  build/release/ringsplat --man | docs/option_page.py > docs/options.md"""
import re
import sys
import textwrap

HEAD = """# Options

Made from `ringsplat --man` by `docs/option_page.py`; a test compares the two. `ringsplat SUBCOMMAND --help` shows
the everyday options, `--help-all` all of them, `man ringsplat` the same as this page.
[command-line.md](command-line.md) says what holds for all of them, how views, series and clip boxes are given and how
roles are chosen. Defaults are in brackets. Options that several subcommands have are explained where they come first;
of what goes with what, the manual page says more.
"""
WIDTH = 120
# Of each subcommand; said once.
EVERYWHERE = ("--help", "--help-all")


def plain(text):
    """roff's text without its escapes."""
    return re.sub(r"\\f[BIR]", "", text).replace("\\-", "-").replace("\\e", "\\").replace("\\&", "").strip()


def tag_of(line):
    """The code and the default of an option's heading: \\fB\\-\\-fov\\fR \\fIDEGREES\\fR [40]."""
    shown, default = re.fullmatch(r"(.*?)( \[[^\]]*\])?", plain(line)).groups()
    return f"`{shown}`" + (default or "")


def safe(text):
    """A sentence with Markdown's marks escaped, and --options as code."""
    return re.sub(r"(?<![\w`-])(--[a-z][\w-]*)", r"`\1`", text.replace("*", r"\*").replace("_", r"\_").replace("<", r"\<"))


def item(tag, text):
    return textwrap.fill(f"- {tag}: {safe(text)}", WIDTH, subsequent_indent="  ", break_long_words=False, break_on_hyphens=False)


class Page:
    def __init__(self):
        self.parts, self.seen, self.again, self.subcommand = [HEAD], {}, [], False

    def end_group(self):
        """Names what the subcommand shares with one before it."""
        if self.again:
            names = ", ".join(f"`{name}`" for name in self.again)
            self.parts.append(textwrap.fill(f"- As above: {names}", WIDTH, subsequent_indent="  ", break_on_hyphens=False))
        self.again = []

    def heading(self, marks, title):
        self.end_group()
        self.parts.append(f"\n{marks} {title}\n")

    def option(self, tag, text):
        name = re.search(r"--[a-z][a-z-]*", tag)
        if self.subcommand and name and name[0] in EVERYWHERE:
            return
        # What it needs and contradicts differs with what else a subcommand has.
        told = re.sub(r" (Not with|Needs) .*", "", text)
        if name and self.seen.get(tag) == told:
            self.again.append(name[0])
            return
        self.seen[tag] = told
        if not self.parts[-1].startswith(("-", "\n")):
            self.parts.append("")
        self.parts.append(item(tag, text))


def page_of(lines):
    page, example = Page(), []
    lines = iter(lines)
    for line in lines:
        if line.startswith(".SH"):
            title = plain(line[4:]).lower()
            page.subcommand = title.startswith("ringsplat ")
            if page.subcommand or title in ("options", "configuration files", "exit status"):
                page.heading("##", f"`{title}`" if page.subcommand else title.capitalize())
        elif line.startswith(".SS"):
            page.heading("###", plain(line[4:]))
        elif line.startswith(".TP"):
            page.option(tag_of(next(lines)), plain(next(lines)))
        elif line.startswith(".nf"):
            example = []
            while not (shown := next(lines)).startswith(".fi"):
                example.append(plain(shown))
            if page.subcommand:
                page.parts.append("```sh\n" + "\n".join(example) + "\n```")
        elif not line.startswith(".") and page.parts[-1].startswith("\n##"):
            page.parts.append(textwrap.fill(safe(plain(line)), WIDTH, break_on_hyphens=False))
    page.end_group()
    return re.sub(r"\n{3,}", "\n\n", "\n".join(page.parts)).strip() + "\n"


if __name__ == "__main__":
    sys.stdout.write(page_of(sys.stdin.read().splitlines()))
