#!/usr/bin/env python3
"""bundle.py --out FILE.cpp [--esbuild PROGRAM]: the page as one self-contained HTML document in a C++ source.

esbuild makes one script of the *.ts and one style of viewer.css. Both are put into index.html; the document's
Content-Security-Policy names them by their hash, so that no other script can run. Without esbuild it is absent.html, which
says how to build the page.
"""

import argparse
import base64
import hashlib
import pathlib
import subprocess

HERE = pathlib.Path(__file__).resolve().parent
LINE = 24  # numbers


def bundled(esbuild, name, *flags):
    made = subprocess.run([esbuild, HERE / name, "--bundle", "--minify", "--charset=utf8", "--log-level=warning", *flags],
                          capture_output=True, text=True, check=False)
    if made.returncode != 0 or made.stderr:
        raise SystemExit(f"bundle.py: {name}: {made.stderr}")
    return made.stdout.strip()


def hash_of(text):
    return "'sha256-" + base64.b64encode(hashlib.sha256(text.encode()).digest()).decode() + "'"


def document(esbuild):
    """(HTML, policy)"""
    if not esbuild:
        return (HERE / "absent.html").read_text(encoding="utf-8"), "default-src 'none'"
    style = bundled(esbuild, "viewer.css")
    script = bundled(esbuild, "main.ts", "--format=iife", "--target=es2020")
    if "</script" in script or "</style" in style:
        raise SystemExit("bundle.py: what is bundled would end its own element")
    html = (HERE / "index.html").read_text(encoding="utf-8")
    for mark, made in (("<!-- style -->", f"<style>{style}</style>"), ("<!-- script -->", f"<script>{script}</script>")):
        if html.count(mark) != 1:
            raise SystemExit(f"bundle.py: index.html: needs one {mark}")
        html = html.replace(mark, made)
    policy = (f"default-src 'none'; script-src {hash_of(script)}; style-src {hash_of(style)}; connect-src 'self'; "
              "img-src data:; base-uri 'none'; form-action 'none'; frame-ancestors 'none'")
    return html, policy


def source(html, policy, has_page):
    data = html.encode()
    lines = [",".join(map(str, data[at:at + LINE])) for at in range(0, len(data), LINE)]
    return "\n".join([
        "// Made by host/viewer/page/bundle.py.",
        '#include "host/viewer/page_source.h"',
        "namespace stof::viewer {",
        "namespace {",
        f"constexpr unsigned char kBytes[{len(data)}] = {{",
        ",\n".join(lines),
        "};",
        "}  // namespace",
        f"const std::string_view kPage(reinterpret_cast<const char*>(kBytes), {len(data)});",
        f'const std::string_view kPagePolicy = "{policy}";',
        f"const bool kHasPage = {'true' if has_page else 'false'};",
        "}  // namespace stof::viewer",
        ""])


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=pathlib.Path, required=True)
    parser.add_argument("--esbuild")
    asked = parser.parse_args()
    html, policy = document(asked.esbuild)
    asked.out.write_text(source(html, policy, bool(asked.esbuild)), encoding="utf-8")


if __name__ == "__main__":
    main()
