"""From recordings, bags as they are, to what the model of the arm lacks; the last one is held out.

    python3 from_a_bag.py psm-3dof monday.bag tuesday.bag wednesday.mcap
    python3 from_a_bag.py ur10e monday.bag tuesday.bag tau=A      efforts are motor currents
"""

import sys

import veridyn


def main(robot, *words):
    recordings = [word for word in words if "=" not in word]
    units = ",".join(word for word in words if "=" in word)
    if len(recordings) < 2:
        sys.exit(f"found {len(recordings)} recordings, expected two or more")
    try:
        lacks = veridyn.diagnose(robot, recordings[:-1], recordings[-1], units=units or None)
    except veridyn.InvalidInput as bad:
        sys.exit(str(bad))
    for cause in lacks.findings:
        print(cause["sentence"])
    if not lacks.findings:
        print("The model explains what was recorded.")


if __name__ == "__main__":
    main(*sys.argv[1:])
