"""Functions that a program which includes veridyn's headers links with.

    symbols.py write BUILD    lists them in symbols.txt beside this file (`make symbols`)
    symbols.py check BUILD    status 1 where one of the list went away: programs built before need it

A symbol belongs to the public interface if every word of its qualified name occurs in include/veridyn.
What compilers may inline (weak symbols) is not listed.
"""
import glob
import os
import re
import subprocess
import sys

HERE = os.path.dirname(os.path.abspath(__file__))
ROOT = os.path.dirname(os.path.dirname(HERE))
LIST = os.path.join(HERE, "symbols.txt")
SHORT = [("std::__cxx11::basic_string<char, std::char_traits<char>, std::allocator<char> >", "std::string"),
         ("std::basic_string_view<char, std::char_traits<char> >", "std::string_view"),
         ("Eigen::Matrix<double, -1, -1, 0, -1, -1>", "MatrixXd"), ("Eigen::Matrix<double, -1, 1, 0, -1, 1>", "VectorXd")]


def public_words():
    words = set()
    for path in glob.glob(os.path.join(ROOT, "include", "veridyn", "**", "*.hpp"), recursive=True):
        with open(path) as file:
            code = re.sub(r"//.*", "", file.read())
        words |= set(re.findall(r"~?\w+", code))
    return words


def demangled(symbols):
    text = subprocess.run(["c++filt"], input="\n".join(symbols), capture_output=True, text=True, check=True).stdout
    for long, short in SHORT:
        text = text.replace(long, short)
    return re.sub(r", std::allocator<[^<>]*>(?= ?>)", "", text).splitlines()


def defined(build):
    """Demangled names of the library's own functions."""
    folders = [os.path.join(build, "src"), os.path.join(build, "packages", "*")]
    libraries = sum((glob.glob(os.path.join(folder, "libveridyn_*.a")) or glob.glob(os.path.join(folder, "libveridyn_*.so")) for folder in folders), [])
    libraries = [path for path in libraries if "_commands." not in path]
    if not libraries:
        sys.exit(f"{build}: found no libraries, expected a folder that is built")
    dynamic = ["-D"] if libraries[0].endswith(".so") else []
    lines = subprocess.run(["nm", "--defined-only", *dynamic, *libraries], capture_output=True, text=True, check=True).stdout
    return set(demangled(sorted(set(re.findall(r"^[0-9a-f]+ [TDRB] (_ZNK?7veridyn\w+)$", lines, re.M)))))


def main(what, build):
    names = defined(build)
    if what == "write":
        words = public_words()
        public = [n for n in sorted(names)
                  if all(w in words for w in re.findall(r"~?\w+", re.sub(r"\[abi:\w+\]", "", n.split("(")[0])))]
        with open(LIST, "w") as file:
            file.write("\n".join(public) + "\n")
        print(f"{len(public)} symbols in {os.path.relpath(LIST, ROOT)}")
        return 0
    with open(LIST) as file:
        gone = [line.rstrip("\n") for line in file if line.rstrip("\n") not in names]
    for name in gone:
        print(f"went away: {name}")
    if gone:
        print(f"{len(gone)} public symbols went away: a break of the interface. If it is meant, CHANGELOG.md says so, and `make symbols` lists what there is.")
    return 1 if gone else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1], sys.argv[2]))
