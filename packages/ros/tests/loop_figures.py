#!/usr/bin/env python3
"""How the nodes keep their time: three simulated arms, plant and controller in processes of their own, at 1 kHz.

    loop_figures.py BIN MINUTES [PREFIX...]     BIN: folder with the nodes; after `make ros`, with ROS in PYTHONPATH as
                                                packages/ros/test.sh has it. PREFIX: before each node, as chrt -f 40

All three arms follow streams of 100 Hz meanwhile, and a subscriber that sleeps half a second per message hangs on. Both
nodes tell their figures when they end.
"""
import math
import os
import socket
import subprocess
import sys
import tempfile
import time

BIN, MINUTES, PREFIX = sys.argv[1], float(sys.argv[2]), sys.argv[3:]
with socket.socket() as one:
    one.bind(("127.0.0.1", 0))
    PORT = one.getsockname()[1]
os.environ.update(ROS_MASTER_URI="http://127.0.0.1:%d" % PORT, ROS_IP="127.0.0.1", ROS_HOME=tempfile.mkdtemp(),
                  ROS_LOG_DIR=tempfile.mkdtemp())
import rospy  # noqa: E402
from crtk_msgs.msg import OperatingState, StringStamped  # noqa: E402
from sensor_msgs.msg import JointState  # noqa: E402

ARMS = ["PSM1", "PSM2", "PSM3"]


def main():
    master = subprocess.Popen(["rosmaster", "--core", "-p", str(PORT)], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    while socket.socket().connect_ex(("127.0.0.1", PORT)) != 0:
        time.sleep(0.1)
    rospy.init_node("loop_figures", disable_signals=True)
    for node in ("plant", "controller"):
        rospy.set_param("/veridyn_%s/arms" % node, ARMS)
        for arm in ARMS:
            rospy.set_param("/veridyn_%s/%s/model" % (node, arm), "psm-3dof")
            rospy.set_param("/veridyn_%s/%s/start" % (node, arm), [0.1, 0.05, 0.12])
    rospy.set_param("/veridyn_controller/plant", "topics")
    nodes = [subprocess.Popen(PREFIX + [os.path.join(BIN, "veridyn_" + n)]) for n in ("plant", "controller")]
    state, setpoint = {}, {}
    for arm in ARMS:
        rospy.Subscriber("/%s/operating_state" % arm, OperatingState, lambda m, a=arm: state.update({a: m.state}))
        rospy.Subscriber("/%s/setpoint_js" % arm, JointState, lambda m, a=arm: setpoint.update({a: list(m.position)}))
        rospy.Subscriber("/%s/measured_js" % arm, JointState, lambda m: time.sleep(0.5), queue_size=1)
    command = {a: rospy.Publisher("/%s/state_command" % a, StringStamped, queue_size=10, latch=True) for a in ARMS}
    servo = {a: rospy.Publisher("/%s/servo_jp" % a, JointState, queue_size=1, tcp_nodelay=True) for a in ARMS}
    while len(setpoint) < 3:
        time.sleep(0.1)
    end, faults, t, before = time.monotonic() + 60.0 * MINUTES, 0, 0.0, time.monotonic()
    start = {a: None for a in ARMS}
    while time.monotonic() < end:
        now = time.monotonic()
        t, before = t + min(now - before, 0.02), now
        for arm in ARMS:
            if state.get(arm) != "ENABLED":
                faults += start[arm] is not None
                start[arm] = None
                command[arm].publish(StringStamped(string="enable"))
                continue
            if start[arm] is None:
                start[arm] = (t, setpoint[arm])
            since, q = start[arm][0], start[arm][1]
            fade = min(1.0, t - since)
            servo[arm].publish(JointState(position=[q[0] + fade * 0.2 * math.sin(t - since), q[1] + fade * 0.2 * math.sin(0.7 * (t - since)),
                                                    q[2] + fade * 0.02 * math.sin(1.3 * (t - since))]))
        time.sleep(0.01)
    for node in reversed(nodes):
        node.send_signal(2)
        node.wait(20)
    print("operating states other than ENABLED seen while streaming: %d cycles of the client" % faults)
    rospy.signal_shutdown("done")
    master.send_signal(2)
    master.wait(10)


if __name__ == "__main__":
    main()
