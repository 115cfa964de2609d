#!/bin/sh
# Makes the book of docs/ a site in FOLDER/html that can be read and searched without a network, with the reference of
# the C++ headers in api/ where doxygen is installed. A dead link between pages is an error.
#   [NO_DOXYGEN=1] docs/build-site.sh FOLDER
set -eu
top=$(cd "$(dirname "$0")/.." && pwd)
mkdir -p "$1"
out=$(cd "$1" && pwd)
pages=$out/pages
rm -rf "$pages" "$out/html"
mkdir -p "$pages"
cp "$top"/docs/*.md "$top"/docs/*.png "$top"/docs/*.svg "$pages"
sed 's#](docs/#](#g' "$top/README.md" >"$pages/README.md"
sed 's#](docs/#](#g' "$top/CHANGELOG.md" >"$pages/CHANGELOG.md"
sed -i 's#](\.\./\(README\|CHANGELOG\)\.md#](\1.md#g' "$pages"/*.md
cat >>"$pages/index.md" <<'END'

```{toctree}
:hidden:
:glob:

README
own-robot
tour
[a-z]*
CHANGELOG
```
END
cat >"$pages/conf.py" <<'END'
project = "veridyn"
extensions = ["myst_parser"]
myst_heading_anchors = 4
html_theme = "alabaster"
html_theme_options = {
    "page_width": "84em",
    "description": "Measured dynamics of robot arms",
    "extra_nav_links": {"C++ classes": "api/annotated.html"},
}
html_show_sourcelink = False
highlight_language = "none"
suppress_warnings = ["myst.header"]
END
sphinx-build -q -W --keep-going -j auto -d "$out/doctrees" -b html "$pages" "$out/html"
if [ -z "${NO_DOXYGEN:-}" ] && command -v doxygen >/dev/null; then
  cd "$top"
  { cat docs/Doxyfile; echo "OUTPUT_DIRECTORY = $out/doxygen"; } | doxygen - >/dev/null
  rm -rf "$out/html/api"
  mv "$out/doxygen/html" "$out/html/api"
fi
echo "$out/html/index.html"
