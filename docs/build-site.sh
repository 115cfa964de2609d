#!/bin/sh
# Makes the book of docs/ a site in FOLDER/html that can be read and searched without a network, with the reference of
# the C++ headers in api/ where doxygen is installed. A dead link between pages is an error.
#   [NO_DOXYGEN=1] [VERIDYN=TOOL] docs/build-site.sh FOLDER      TOOL writes the page of all commands
set -eu
top=$(cd "$(dirname "$0")/.." && pwd)
mkdir -p "$1"
out=$(cd "$1" && pwd)
pages=$out/pages
rm -rf "$pages" "$out/html"
mkdir -p "$pages"
# All pages side by side, those of packages too.
cp "$top"/README.md "$top"/CHANGELOG.md "$top"/docs/*.md "$top"/docs/*.png "$top"/docs/*.svg "$top"/packages/*/docs/* "$pages"
cp -r "$top"/docs/causes "$pages"
sed -i -E 's#\]\((\.\./)*(docs/|(packages/)?[a-z]+/docs/)?([A-Za-z0-9-]+\.(md|png|svg))#](\4#g' "$pages"/*.md
tool=${VERIDYN:-$top/build/bin/veridyn}
if [ -x "$tool" ]; then
  "$tool" help --markdown "$pages/commands.md"
else
  printf '# Commands\n\n`make tool` before `make docs` makes this page.\n' >"$pages/commands.md"
fi
# The parts of the book, in the order of index.md, beside every page.
part() {
  printf '\n```{toctree}\n:hidden:\n:caption: %s\n\n' "$1"
  shift
  printf '%s\n' "$@" '```'
}
{
  part Start 'What veridyn is <README>' own-robot start-dvrk python coming-from
  part Understand identification diagnosis causes limits
  part Do excitation recordings robot-files control simulate-export watch scale pages
  part Packages boards board-protocol cooperation stability calibration ros
  part 'Look up' commands contract glossary thesis thesis-figures CHANGELOG
  part 'Carry on' design style adding-an-effect developing measure
} >>"$pages/index.md"
mkdir "$pages/_static"
cat >"$pages/_static/book.css" <<'END'
td img { max-width: none !important; }
table.docutils { margin-left: 0; }
div.body pre { font-size: 0.76em; padding: 7px 12px; overflow-x: auto; }
div.sphinxsidebar p.caption { font-weight: bold; margin: 0.8em 0 0.2em; }
div.sphinxsidebar a { border-bottom: none; }
div.sphinxsidebar h3 { margin-top: 0.8em; }
END
cat >"$pages/conf.py" <<'END'
project = "veridyn"
extensions = ["myst_parser"]
myst_heading_anchors = 4
html_theme = "alabaster"
html_static_path = ["_static"]
html_css_files = ["book.css"]
html_sidebars = {"**": ["about.html", "searchbox.html", "navigation.html"]}
html_theme_options = {
    "font_family": "system-ui, sans-serif",
    "head_font_family": "system-ui, sans-serif",
    "sidebar_collapse": True,
    "page_width": "min(84em, 96vw)",
    "body_max_width": "none",
    "description": "Measured dynamics of robot arms",
    "extra_nav_links": {"C++ classes": "api/annotated.html", "C++ functions": "api/namespaceveridyn.html"},
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
  cp "$out/html/api/annotated.html" "$out/html/api/index.html"  # its own would be empty
fi
echo "$out/html/index.html"
