#!/usr/bin/env python3
"""Counts what makes English hard to read: sentences over 25 words, and banned phrases.

usage: readability.py [--check] [--rev REVISION] [--worst N]

Read are README.md, the pages, `berth --help` with that of every command, and the texts in the code that a user sees: string
literals of messages, rig files, templates and scripts of pages. --check: exit code 1 where a banned phrase stands in any of them. --rev: README of another
revision alone, to compare.
"""

import argparse
import ast
import re
import subprocess
import sys

import readme

ROOT = readme.ROOT
WORDS_MAX = 25
# Phrases that hide who does what, or that no field uses.
BANNED = ["is told", "are told", "is said", "are said", "is asked", "are asked", "is borne", "makes up for", "stands in for",
          "stand in for", "is off by", "are off by", "its finer ways", "what is left of", "goes without", "is believed",
          "are believed", "is late by", "are late by", "comes of nothing", "does as well as", "to every digit", "blows up", "told a", "as told",
          "tells neither"]
PROSE_OF_QUOTES = {"contributing.md"}  # quotes what not to write
SENTENCE_END = re.compile(r"(?<=[.!?:;])\s+(?=[A-Z`*\"(\[0-9]|berth)")


def prose(markdown):
    """Paragraphs and list items of a page; code, tables, headings and addresses of links are no prose."""
    text = re.sub(r"^(```+).*?^\1", "\n\n", markdown, flags=re.S | re.M)
    text = re.sub(r"!\[[^\]]*\]\([^)]*\)", "", text)
    text = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", text)
    lines = ["" if line.startswith(("|", "#", "    ")) else line for line in text.splitlines()]
    text = re.sub(r"^\s*(?:[-*]|\d+\.)\s+", "\n\n", "\n".join(lines), flags=re.M)
    return [" ".join(part.split()) for part in re.split(r"\n\s*\n", text) if part.strip()]


def tables(markdown):
    """The cells of a page's tables."""
    lines = re.sub(r"^(```+).*?^\1", "", markdown, flags=re.S | re.M).splitlines()
    return [cell.strip() for line in lines if line.startswith("|") for cell in line.strip("|").split("|")]


def sentences(paragraphs):
    return [sentence for paragraph in paragraphs for sentence in SENTENCE_END.split(paragraph) if sentence.split()]


def banned_in(text):
    flat = " ".join(text.split()).lower()
    return [phrase for phrase in BANNED for _ in range(len(re.findall(rf"\b{re.escape(phrase)}\b", flat)))]


def help_texts():
    def berth(*words):
        return subprocess.run([ROOT / "build" / "berth", *words], capture_output=True, text=True, check=True).stdout

    top = berth("--help")
    names = re.findall(r"^  (\S+) +\S", top.split("Subcommands:")[1], re.M)
    return {"--help": top} | {f"{name} --help": berth(name, "--help") for name in names}


def literals(source):
    """String literals of a Python source: implicit parts are one, an f-string is what stands around its values. Comments of
    functions are none; the module's is, as it is the help."""
    tree = ast.parse(source)
    comments = {id(one.value) for one in ast.walk(tree) if isinstance(one, ast.Expr)} - {id(getattr(tree.body[0], "value", None))}
    inner = {id(part) for one in ast.walk(tree) if isinstance(one, ast.JoinedStr) for part in ast.walk(one) if part is not one}
    for node in ast.walk(tree):
        if id(node) in comments | inner:
            continue
        if isinstance(node, ast.JoinedStr):
            yield "".join(str(part.value) if isinstance(part, ast.Constant) else "0" for part in node.values)
        elif isinstance(node, ast.Constant) and isinstance(node.value, str):
            yield node.value


def texts_of(path):
    """What a user reads of a source: its messages, or all of a rig, a page's template and its script."""
    text = path.read_text(errors="replace")
    if path.suffix == ".py":
        return list(literals(text))
    if path.suffix in (".cpp", ".c", ".h"):
        return re.findall(r'"((?:[^"\\\n]|\\.)*)"', re.sub(r'"\s*\n\s*"', "", text))
    if path.suffix == ".html":
        text = re.sub(r"<[^>]*>", " ", text)
    return [re.sub(r"""["'`]\s*\+\s*["'`]""", "", text)]


def messages():
    """(file, text of more than two words) of the sources that print or are shown."""
    for folder in ("sim_hal", "hal", "firmware", "scripts", "tests/scenarios"):
        for path in sorted((ROOT / folder).rglob("*")):
            if path.suffix in (".cpp", ".c", ".h", ".py", ".toml", ".js", ".html") and path.name != "readability.py":
                for text in texts_of(path):
                    if len(text.split()) > 2:
                        yield str(path.relative_to(ROOT)), text


def pages(revision):
    """{name: Markdown}."""
    if revision:
        text = subprocess.run(["git", "show", f"{revision}:README.md"], cwd=ROOT, capture_output=True, text=True, check=True)
        return {f"README.md of {revision}": text.stdout}
    return {str(page.relative_to(ROOT)): page.read_text() for page in readme.pages()}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--check", action="store_true", help="exit code 1 where a banned phrase stands")
    parser.add_argument("--rev", help="README of this revision alone")
    parser.add_argument("--worst", type=int, default=0, help="print so many of the longest sentences")
    arguments = parser.parse_args()
    texts, found, long, all_of = pages(arguments.rev), [], [], []
    for name, text in texts.items():
        parts = prose(text)
        if name.rsplit("/", 1)[-1] not in PROSE_OF_QUOTES:
            found += [(name, phrase) for phrase in banned_in(" . ".join(parts + tables(text)))]
        all_of += [(name, sentence) for sentence in sentences(parts)]
    long = [(name, sentence) for name, sentence in all_of if len(sentence.split()) > WORDS_MAX]
    words = sum(len(sentence.split()) for _, sentence in all_of)
    print(f"pages: {len(texts)}, {words} words of prose in {len(all_of)} sentences, {words / len(all_of):.1f} words each")
    print(f"  over {WORDS_MAX} words: {len(long)} ({100 * len(long) / len(all_of):.1f} %), banned phrases: {len(found)}")
    if not arguments.rev:
        helps = help_texts()
        in_help = [(name, phrase) for name, text in helps.items() for phrase in banned_in(text)]
        in_messages = [(name, phrase) for name, literal in messages() for phrase in banned_in(literal)]
        print(f"--help of {len(helps) - 1} commands, banned phrases: {len(in_help)}")
        print(f"messages in the code, banned phrases: {len(in_messages)}")
        found += in_help + in_messages
    for name, sentence in sorted(long, key=lambda pair: -len(pair[1].split()))[:arguments.worst]:
        print(f"  {name}, {len(sentence.split())} words: {sentence}")
    for name, phrase in found if not arguments.rev else ():
        print(f"{name}: \"{phrase}\"")
    return 1 if arguments.check and found else 0


if __name__ == "__main__":
    sys.exit(main())
