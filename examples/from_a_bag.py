"""From two recordings, bags as they are, to what the model of the arm lacks.

    python3 from_a_bag.py psm-3dof monday.bag tuesday.mcap
    python3 from_a_bag.py ur10e monday.bag tuesday.bag tau=A      efforts are motor currents
"""

import sys

import veridyn


def main(robot, train, test, *units):
    try:
        lacks = veridyn.diagnose(robot, train, test, units=",".join(units) or None)
    except veridyn.InvalidInput as bad:
        sys.exit(str(bad))
    for cause in lacks.findings:
        print(cause["sentence"])
    if not lacks.findings:
        print("The model explains what was recorded.")


if __name__ == "__main__":
    main(*sys.argv[1:])
