"""A program under the address and undefined-behaviour sanitizers, without a second build of the library.

    sanitized_program.py BUILD PROGRAM...    makes BUILD/sanitized/PROGRAM, for instance veridyn or test_hide_and_seek

The files of a program itself, and those of archives that no other program tests (OWN), are compiled anew with the sanitizers;
the rest is linked as BUILD has it. The sanitizers then see every access that these files make, and all memory that is freed
twice, leaked or asked for in sizes that cannot be, whoever does it; `make sanitize` sees the library's accesses too.
"""
import functools
import json
import os
import shlex
import shutil
import subprocess
import sys

OWN = ["tests/libveridyn_hide_and_seek.a", "emulator/libveridyn_emulator.a"]
FLAGS = ["-O1", "-g1", "-UNDEBUG", "-fsanitize=address,undefined", "-fno-sanitize-recover=undefined", "-fno-omit-frame-pointer", "-w"]


def ninja(build, *words):
    return subprocess.run(["ninja", "-C", build, *words], capture_output=True, text=True, check=True).stdout


@functools.lru_cache(None)
def compile_with_sanitizers(build, command, folder):
    """Compiles one object; its precompiled header, if any, is compiled with the same flags once."""
    words = [word for word in shlex.split(command) if word not in ("-Werror", "-Winvalid-pch")]
    if "-include" in words:
        at = words.index("-include") + 1
        header = os.path.join(folder, os.path.relpath(words[at], build).replace("/", "_"))
        if not os.path.exists(header + ".gch"):
            with open(header, "w") as file:
                file.write(f'#include "{words[at]}"\n')
            first = words[:words.index("-o")] + FLAGS
            del first[at - 1:at + 1]
            subprocess.run(first + ["-x", "c++-header", "-o", header + ".gch", header], cwd=build, check=True)
        words[at] = header
    out = words[words.index("-o") + 1]
    target = os.path.join(folder, out.replace("/", "_"))
    words[words.index("-o") + 1] = target
    words[words.index("-c"):words.index("-c")] = FLAGS
    subprocess.run(words, cwd=build, check=True)
    return target


def main(build, programs):
    build = os.path.abspath(build)
    folder = os.path.join(build, "sanitized")
    shutil.rmtree(folder, ignore_errors=True)
    os.makedirs(folder)
    ninja(build, *["bin/" + program for program in programs])
    with open(os.path.join(build, "compile_commands.json")) as file:
        commands = {word: entry["command"] for entry in json.load(file)
                    for word in [shlex.split(entry["command"])[shlex.split(entry["command"]).index("-o") + 1]]}
    for program in programs:
        link = shlex.split(ninja(build, "-t", "commands", "bin/" + program).strip().splitlines()[-1])
        link = link[2:link.index("&&", 2)]
        words = []
        for word in link:
            objects = [word] if word in commands else []
            if word in OWN:
                objects = [o for o in ninja(build, "-t", "query", word).split() if o in commands]
            words += [compile_with_sanitizers(build, commands[o], folder) for o in objects] or [word]
        words[words.index("-o") + 1] = os.path.join(folder, program)
        subprocess.run(words + ["-fsanitize=address,undefined"], cwd=build, check=True)
        print(os.path.join(folder, program))


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2:])
