#!/usr/bin/env python3
"""A laboratory's client of the nodes, against a master of its own: Debian's rospy and nothing else.

    laboratory.py BIN TOOL     BIN: folder with the nodes, TOOL: the tool veridyn
"""
import json
import math
import os
import re
import signal
import socket
import subprocess
import sys
import tempfile
import threading
import time
import unittest
import warnings

BIN, TOOL = sys.argv[1:3]
warnings.simplefilter("ignore", ResourceWarning)  # of rospy's own sockets


def free_port():
    with socket.socket() as s:
        s.bind(("127.0.0.1", 0))
        return s.getsockname()[1]


PORT = free_port()
os.environ.update(ROS_MASTER_URI="http://127.0.0.1:%d" % PORT, ROS_IP="127.0.0.1",
                  ROS_HOME=tempfile.mkdtemp(), ROS_LOG_DIR=tempfile.mkdtemp())

import rosbag  # noqa: E402
import rospy  # noqa: E402
from crtk_msgs.msg import OperatingState, StringStamped  # noqa: E402
from geometry_msgs.msg import PointStamped, PoseStamped, Twist, WrenchStamped  # noqa: E402
from rosgraph_msgs.msg import Clock  # noqa: E402
from sensor_msgs.msg import JointState, Joy  # noqa: E402
from std_msgs.msg import Bool, Empty, Float64, String  # noqa: E402


def wait_for(what, seconds, text):
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        if what():
            return
        time.sleep(0.01)
    raise AssertionError("after %g s: %s" % (seconds, text() if callable(text) else text))


def start(node, **parameters):
    """A node with private parameters, through the parameter server as launch files do."""
    for name, value in parameters.items():
        rospy.set_param("/veridyn_%s/%s" % (node, name.replace("__", "/")), value)
    return subprocess.Popen([os.path.join(BIN, "veridyn_" + node)], stderr=subprocess.PIPE,
                            stdout=subprocess.DEVNULL, text=True)


def start_script(name, stdin, parameters):
    for key, value in parameters.items():
        rospy.set_param("/veridyn_%s/%s" % (name, key), value)
    script = os.path.join(os.path.dirname(os.path.abspath(__file__)), "../veridyn_ros/scripts/veridyn_" + name)
    return subprocess.Popen([sys.executable, "-W", "ignore", script], stdin=stdin, stderr=subprocess.PIPE,
                            stdout=subprocess.DEVNULL, text=True)


def stop(process, how=signal.SIGINT):
    if process.poll() is None:
        process.send_signal(how)
    try:
        process.wait(10)
    except subprocess.TimeoutExpired:
        process.kill()
        process.wait()


class Arm:
    """What crtk.utils does, in few lines."""

    def __init__(self, name):
        self.heard, self.said = {}, []
        kinds = {"measured_js": JointState, "setpoint_js": JointState, "measured_cp": PoseStamped,
                 "measured_cf": WrenchStamped, "operating_state": OperatingState}
        self.subscribers = [rospy.Subscriber("/%s/%s" % (name, n), k, self.hear(n)) for n, k in kinds.items()]
        self.subscribers.append(rospy.Subscriber("/%s/warning" % name, String, lambda m: self.said.append(m.data)))
        self.publishers = {n: rospy.Publisher("/%s/%s" % (name, n), k, queue_size=10) for n, k in {
            "servo_jp": JointState, "move_jp": JointState, "servo_jf": JointState, "servo_cp": PoseStamped,
            "move_cp": PoseStamped, "cmd_vel": Twist, "hold": Empty, "state_command": StringStamped}.items()}

    def hear(self, name):
        def note(message):
            self.heard[name] = message
        return note

    def ready(self):
        return "measured_js" in self.heard and all(p.get_num_connections() > 0 for p in self.publishers.values())

    def joints(self):
        return list(self.heard["measured_js"].position)

    def state(self):
        return self.heard["operating_state"].state

    def say(self, word):
        self.publishers["state_command"].publish(StringStamped(string=word))

    def ask(self, name, joints):
        self.publishers[name].publish(JointState(position=joints))

    def off(self, joints):
        return max(abs(a - b) for a, b in zip(self.joints(), joints))


class Laboratory(unittest.TestCase):
    ARM = {"arms": ["PSM1"], "PSM1__model": "psm-3dof", "PSM1__start": [0.1, 0.05, 0.12]}

    @classmethod
    def setUpClass(cls):
        cls.master = subprocess.Popen(["rosmaster", "--core", "-p", str(PORT)], stdout=subprocess.DEVNULL,
                                      stderr=subprocess.DEVNULL)
        wait_for(lambda: socket.socket().connect_ex(("127.0.0.1", PORT)) == 0, 20, "no master")
        rospy.init_node("laboratory", disable_signals=True)
        cls.arm = Arm("PSM1")

    @classmethod
    def tearDownClass(cls):
        rospy.signal_shutdown("done")
        stop(cls.master)

    def setUp(self):
        self.processes = []
        self.arm.heard.clear()
        self.arm.said.clear()

    def tearDown(self):
        for process in self.processes:
            stop(process)
            process.stderr.close()
            if process.stdout is not None:
                process.stdout.close()

    def run_node(self, node, **parameters):
        self.processes.append(start(node, **parameters))
        return self.processes[-1]

    def run_script(self, name, stdin=subprocess.DEVNULL, **parameters):
        self.processes.append(start_script(name, stdin, parameters))
        return self.processes[-1]

    def enabled(self, **parameters):
        self.run_node("controller", plant="inside", **self.ARM, **parameters)
        self.enable()

    def enable(self):
        wait_for(self.arm.ready, 30, "the arm is not there")
        wait_for(lambda: "operating_state" in self.arm.heard, 5, "no operating state")
        self.arm.say("enable")
        wait_for(lambda: self.arm.state() == "ENABLED", 5, "not enabled")

    def stream(self, path, seconds):
        """servo_jp along path(t) beyond where the setpoint is. A machine that is busy makes it slower, not jerkier."""
        t, before, start = 0.0, time.monotonic(), list(self.arm.heard["setpoint_js"].position)
        while t < seconds:
            now = time.monotonic()
            t, before = t + min(now - before, 0.02), now
            self.arm.ask("servo_jp", [a + b for a, b in zip(start, path(t))])
            time.sleep(0.005)

    def test_moves_and_tells_when_it_arrived(self):
        self.enabled()
        self.assertEqual(self.arm.heard["measured_js"].name, ["yaw", "pitch", "insertion"])
        goal = [0.2, -0.05, 0.13]
        self.arm.ask("move_jp", goal)
        wait_for(lambda: self.arm.heard["operating_state"].is_busy, 2, "never busy")
        wait_for(lambda: not self.arm.heard["operating_state"].is_busy, 10, "never arrived")
        wait_for(lambda: self.arm.off(goal) < 3e-3, 3, "is %s" % self.arm.joints())
        here = self.arm.heard["measured_cp"]
        here.header.stamp = rospy.Time(0)
        here.pose.position.x += 0.005
        self.arm.publishers["move_cp"].publish(here)
        wait_for(lambda: abs(self.arm.heard["measured_cp"].pose.position.x - here.pose.position.x) < 1e-3, 10,
                 "the tip did not go there")

    def test_commands_that_cannot_be_are_refused(self):
        self.enabled()
        before = self.arm.joints()
        for joints, words in (([math.nan, 0, 0.1], "not finite"), ([0, 9, 0.1], "limits"), ([0, 0], "number of joints")):
            self.arm.said.clear()
            self.arm.ask("servo_jp", joints)
            wait_for(lambda: any(words in s for s in self.arm.said), 3, "not refused: %s" % joints)
        self.arm.said.clear()
        old = JointState(position=before)
        old.header.stamp = rospy.Time.now() - rospy.Duration(5)
        self.arm.publishers["servo_jp"].publish(old)
        wait_for(lambda: any("too old" in s for s in self.arm.said), 3, "an old command was taken")
        self.arm.say("jump")
        wait_for(lambda: any("found 'jump'" in s for s in self.arm.said), 3, "not refused: jump")
        self.assertEqual(self.arm.state(), "ENABLED")
        self.assertLess(self.arm.off(before), 2e-3)

    def test_a_stream_that_falls_silent_is_held_and_then_let_go(self):
        self.enabled()
        here = self.arm.joints()
        for k in range(50):
            self.arm.ask("servo_jp", [here[0] + 0.002 * k, here[1], here[2]])
            time.sleep(0.01)
        self.arm.said.clear()
        wait_for(lambda: any("held" in s for s in self.arm.said), 2, "not told")
        time.sleep(0.3)
        held = self.arm.joints()
        time.sleep(0.3)
        self.assertLess(self.arm.off(held), 2e-3)

    def test_the_watch_and_a_bag(self):
        bag = os.path.join(os.environ["ROS_HOME"], "run.bag")
        self.enabled(publish_rate=200)
        events = []
        self.run_node("watch", **self.ARM)
        listener = rospy.Subscriber("/PSM1/watch/event", String, lambda m: events.append(json.loads(m.data)))
        with rosbag.Bag(bag, "w") as out:
            lock = threading.Lock()

            def write(message):
                with lock:
                    out.write("/PSM1/measured_js", message, message.header.stamp)
            writer = rospy.Subscriber("/PSM1/measured_js", JointState, write)
            self.stream(lambda t: [min(1.0, t) * a * math.sin(w * t) for a, w in ((0.3, 1.7), (0.25, 1.3), (0.03, 2.1))], 12.0)
            writer.unregister()
            with lock:
                pass
        listener.unregister()
        self.assertEqual(events, [], "a quiet arm")
        done = subprocess.run([TOOL, "identify", "psm-3dof", "--train", bag, "--json", bag + ".json", "--quiet"],
                              capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, done.stderr)
        with open(bag + ".json") as file:
            errors = json.load(file)["train"]["relative_error"]
        self.assertLess(max(errors), 0.3, errors)

    def test_killing_a_node_leaves_the_arm_held(self):
        self.run_node("plant", **self.ARM)
        controller = self.run_node("controller", plant="topics", **self.ARM)
        self.enable()
        io = {}
        listener = rospy.Subscriber("/PSM1/io/measured_js", JointState, lambda m: io.update(m=m))
        goal = [0.2, -0.05, 0.13]
        self.arm.ask("move_jp", goal)
        time.sleep(0.4)
        stop(controller, signal.SIGKILL)
        time.sleep(0.2)
        held = list(io["m"].position)
        time.sleep(0.5)
        self.assertEqual(list(io["m"].position), held)
        self.assertEqual(max(map(abs, io["m"].velocity)), 0.0)
        listener.unregister()

    def test_losing_the_plant_is_a_fault(self):
        plant = self.run_node("plant", **self.ARM)
        self.run_node("controller", plant="topics", **self.ARM)
        self.enable()
        stop(plant, signal.SIGKILL)
        wait_for(lambda: self.arm.state() == "FAULT", 5, "the controller did not notice")

    def test_boards_have_power_under_a_controller_alone(self):
        port = free_port()
        model = os.path.join(os.path.dirname(os.path.abspath(__file__)), "../../../examples/dvrk/light-psm.yaml")
        self.processes.append(subprocess.Popen([TOOL, "dvrk", "emulate", "--arm", "PSM1", "--model", model, "--port", str(port)],
                                               stderr=subprocess.PIPE, stdout=subprocess.PIPE, text=True))
        self.processes[0].stdout.readline()  # it listens
        patient = {"oldest_positions": 0.3, "longest_cycle": 0.3}  # of a machine that is busy
        boards = {"arms": ["PSM1"], "PSM1__port": port, "PSM1__joints": 3, "PSM1__watchdog": 0.3, "patience": 0.15}
        states = []
        listener = rospy.Subscriber("/PSM1/io/state", String, lambda m: states.append(m.data))
        node = self.run_node("boards", **boards)
        lead = {"arms": ["PSM1"], "PSM1__model": model, "plant": "topics", **patient}
        controller = self.run_node("controller", **lead)
        wait_for(lambda: states or node.poll() is not None, 20, "the boards say nothing")
        self.assertTrue(states, node.poll() is not None and node.stderr.read())
        self.assertEqual(states[-1], "off")
        self.enable()
        wait_for(lambda: states[-1] == "on", 20, "no power: %s" % states)
        self.assertIn("powering up", states)
        goal = [0.2, -0.05, 0.13]
        for _ in range(6):  # a machine that pauses is a fault, rightly
            if self.arm.state() != "ENABLED":
                self.arm.say("enable")
            wait_for(lambda: self.arm.state() == "ENABLED" and states[-1] == "on" and not self.arm.heard["operating_state"].is_busy,
                     20, lambda: "%s %s" % (states, self.arm.said))
            self.arm.ask("move_jp", goal)
            try:
                wait_for(lambda: self.arm.off(goal) < 5e-3 or self.arm.state() != "ENABLED", 8, "slow")
            except AssertionError:
                continue
            if self.arm.off(goal) < 5e-3:
                break
        self.assertLess(self.arm.off(goal), 5e-3, (self.arm.state(), self.arm.said, states))
        stop(controller, signal.SIGKILL)
        wait_for(lambda: states[-1] == "off", 5, "power without a controller: %s" % states)
        # A new controller takes over; then the boards' node itself is killed: their watchdogs are what is left.
        self.arm.heard.clear()
        controller = self.run_node("controller", **lead)
        self.enable()
        wait_for(lambda: states[-1] == "on", 20, "no power again: %s" % states)
        stop(node, signal.SIGKILL)
        wait_for(lambda: self.arm.state() == "FAULT", 10, "the controller did not notice")
        look = subprocess.run([TOOL, "dvrk", "monitor", "--arm", "PSM1", "--port", str(port), "--seconds", "0.5"],
                              capture_output=True, text=True)
        self.assertEqual(look.returncode, 0, look.stderr)
        amplifiers = re.findall(r"^ +[1-7] .* (on|off)$", look.stdout, re.MULTILINE)
        self.assertEqual(amplifiers, ["off"] * 7, look.stdout)
        listener.unregister()

    def test_a_motion_is_played_and_its_bag_identifies_and_diagnoses(self):
        folder = os.environ["ROS_HOME"]
        motion, bag, found = folder + "/motion.csv", folder + "/play.bag", folder + "/found.yaml"
        with open(motion, "w") as file:
            file.write("t,q1,q2,q3\n")
            for k in range(1201):
                t = 0.01 * k
                waves = [min(1.0, 0.5 * t) * (a * math.sin(w * t) + 0.3 * a * math.sin(2.7 * w * t))
                         for a, w in ((0.25, 1.7), (0.25, 1.3), (0.03, 2.1))]
                file.write("%g,%.6f,%.6f,%.6f\n" % (t, waves[0], waves[1], 0.12 + waves[2]))
        self.run_node("controller", plant="inside", publish_rate=200, **self.ARM)
        play = self.run_script("play", arm="PSM1", trajectory=motion, record=bag)
        self.assertEqual(play.wait(120), 0, play.stderr.read())
        done = subprocess.run([TOOL, "identify", "psm-3dof", "--train", bag, "--model-out", found, "--json", bag + ".json", "--quiet"],
                              capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, done.stderr)
        with open(bag + ".json") as file:
            errors = json.load(file)["train"]["relative_error"]
        self.assertLess(max(errors), 0.1, errors)
        done = subprocess.run([TOOL, "diagnose", found, "--train", bag, "--test", bag, "--rows", "0:1200",
                               "--test-rows", "1200:2200", "--json", bag + ".diagnosis", "--quiet"], capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        with open(bag + ".diagnosis") as file:
            errors = json.load(file)["baseline"]["test"]["relative_error"]
        self.assertLess(max(errors), 0.05, done.stdout)  # nothing large is wrong; torques lead by half a cycle, which may be told
        play = self.run_script("play", arm="PSM1", trajectory=folder + "/none.csv")
        self.assertEqual(play.wait(60), 3)
        self.assertIn("none.csv", play.stderr.read())

    def test_a_master_leads_a_slave_while_the_clutch_is_closed(self):
        other = Arm("PSM2")
        two = dict(self.ARM, arms=["PSM1", "PSM2"], PSM2__model="psm-3dof", PSM2__start=[-0.1, 0.1, 0.1])
        self.run_node("controller", plant="inside", publish_rate=200, **two)
        self.enable()
        wait_for(lambda: other.ready() and "operating_state" in other.heard, 20, "the slave is not there")
        other.say("enable")
        wait_for(lambda: other.state() == "ENABLED", 5, "the slave is not enabled")
        self.run_script("teleoperate", master="PSM1", slave="PSM2", scale=0.5)
        pedal = rospy.Publisher("/veridyn_teleoperate/clutch", Joy, queue_size=1)
        following = []
        listener = rospy.Subscriber("/veridyn_teleoperate/following", Bool, lambda m: following.append(m.data))
        wait_for(lambda: pedal.get_num_connections() > 0 and following, 20, "no teleoperation")

        def tips():
            return [[getattr(a.heard["measured_cp"].pose.position, c) for c in "xyz"] for a in (self.arm, other)]

        def lead(by):
            self.stream(lambda t: [by * min(1.0, t), 0.0, 0.0], 1.3)
            time.sleep(0.5)

        before = tips()
        lead(0.1)  # the clutch is open
        self.assertLess(max(abs(a - b) for a, b in zip(tips()[1], before[1])), 1e-3)
        for by in (-0.1, 0.1, -0.1, 0.1):  # again where this machine paused, so that the clutch opened by itself
            pedal.publish(Joy(buttons=[1]))
            wait_for(lambda: following[-1], 5, "the clutch did not close")
            before, closings = tips(), len(following)
            lead(by)
            after = tips()
            if len(following) == closings:
                break
        for c in range(3):
            self.assertAlmostEqual(after[1][c] - before[1][c], 0.5 * (after[0][c] - before[0][c]), delta=1.5e-3)
        self.assertGreater(max(abs(a - b) for a, b in zip(after[0], before[0])), 5e-3)
        pedal.publish(Joy(buttons=[0]))
        wait_for(lambda: not following[-1], 5, "the clutch did not open")
        listener.unregister()
        for each in other.subscribers:
            each.unregister()

    def test_keys_lead_an_arm(self):
        self.enabled()
        keys = self.run_script("keyboard", stdin=subprocess.PIPE, arm="PSM1", speed=0.02)
        here, end = self.arm.heard["measured_cp"].pose.position.z, time.monotonic() + 30.0
        while self.arm.heard["measured_cp"].pose.position.z - here < 0.01 and time.monotonic() < end:
            keys.stdin.write("r")
            keys.stdin.flush()
            time.sleep(0.1)
        self.assertGreater(self.arm.heard["measured_cp"].pose.position.z - here, 0.01, "the tip did not rise")
        keys.stdin.write("q")
        keys.stdin.flush()
        self.assertEqual(keys.wait(10), 0)
        keys.stdin.close()

    def test_two_arms_are_led_with_an_object(self):
        root = os.path.join(os.path.dirname(os.path.abspath(__file__)), "../../..")
        self.run_node("cooperate", scenario=os.path.join(root, "examples/cooperate/two-arms-spring.yaml"), space="psm")
        force, tip = [], []
        listeners = [rospy.Subscriber("/spring/force", Float64, lambda m: force.append(m.data)),
                     rospy.Subscriber("/master/tip", PointStamped, lambda m: tip.append(m.point.x))]
        press = rospy.Publisher("/psm/cmd_force", Float64, queue_size=1)
        lead = rospy.Publisher("/psm/cmd_vel", Twist, queue_size=1)
        wait_for(lambda: force and tip and press.get_num_connections() > 0 and lead.get_num_connections() > 0, 30,
                 "no cooperation")
        press.publish(Float64(3.0))
        wait_for(lambda: abs(force[-1] - 3.0) < 0.5, 20, "the force is not there")
        before, twist = tip[-1], Twist()
        twist.linear.x = 0.01
        for _ in range(100):
            lead.publish(twist)
            time.sleep(0.02)
        time.sleep(0.5)
        self.assertGreater(abs(tip[-1] - before), 5e-3)
        self.assertLess(abs(force[-1] - 3.0), 1.0)
        held = tip[-1]
        time.sleep(0.5)  # silence: all is held
        self.assertLess(abs(tip[-1] - held), 1e-3)
        for each in listeners:
            each.unregister()

    def test_a_load_cell_tells_newtons_and_when_it_is_dead(self):
        port, folder = free_port(), os.environ["ROS_HOME"]
        readings = os.path.join(folder, "readings.csv")
        with open(readings, "w") as file:
            file.write("force,raw\n0,100\n5,1100\n10,2100\n")
        done = subprocess.run([TOOL, "loadcell", "calibrate", readings, "-o", folder + "/cell.yaml"], capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, done.stderr)
        heard, said = [], []
        listeners = [rospy.Subscriber("/cell/measured_cf", WrenchStamped, heard.append),
                     rospy.Subscriber("/cell/state", String, lambda m: said.append(m.data))]
        self.run_node("loadcell", source="udp:%d:text" % port, calibration=folder + "/cell.yaml", axis="z")
        line, k = socket.socket(socket.AF_INET, socket.SOCK_DGRAM), 0
        end = time.monotonic() + 30
        while not any(m.header.stamp.to_sec() > 0 for m in heard) and time.monotonic() < end:
            k += 1
            line.sendto(b"%d\n" % (1500 + k % 2), ("127.0.0.1", port))
            time.sleep(0.001)
        good = [m for m in heard if m.header.stamp.to_sec() > 0]
        self.assertTrue(good, said)
        self.assertAlmostEqual(good[-1].wrench.force.z, 7.0, delta=0.05)
        wait_for(lambda: heard[-1].header.stamp.to_sec() == 0, 5, "silence was not noticed")
        for each in listeners:
            each.unregister()

    def test_a_second_client_is_refused_while_the_first_one_streams(self):
        self.enabled()
        here = list(self.arm.heard["setpoint_js"].position)
        other = ("import rospy\nfrom sensor_msgs.msg import JointState\nrospy.init_node('intruder')\n"
                 "p = rospy.Publisher('/PSM1/servo_jp', JointState, queue_size=1)\n"
                 "while not rospy.is_shutdown():\n p.publish(JointState(position=%r))\n rospy.sleep(0.02)\n"
                 % [here[0] - 0.05, here[1], here[2]])
        self.processes.append(subprocess.Popen([sys.executable, "-W", "ignore", "-c", other], stderr=subprocess.PIPE, text=True))
        refused = "another client is commanding the arm"
        end = time.monotonic() + 30
        while not any(refused in s for s in self.arm.said) and time.monotonic() < end:
            self.stream(lambda t: [0.0, 0.0, 0.0], 0.5)
        self.assertTrue(any(refused in s for s in self.arm.said), self.arm.said)
        self.assertEqual(self.arm.state(), "ENABLED")

    def test_a_clock_that_jumps_moves_nothing(self):
        rospy.set_param("/use_sim_time", True)
        try:
            clock = rospy.Publisher("/clock", Clock, queue_size=10, latch=True)
            clock.publish(Clock(rospy.Time(100)))
            self.enabled()
            here = self.arm.joints()

            def ask(seconds):
                command = JointState(position=here)
                command.header.stamp = rospy.Time(seconds)
                self.arm.publishers["servo_jp"].publish(command)
            wait_for(lambda: abs(self.arm.heard["measured_js"].header.stamp.to_sec() - 100) < 2, 20, "the clock is not heard")
            for jump in (5000, 20):  # ahead, and back
                clock.publish(Clock(rospy.Time(jump)))
                wait_for(lambda: abs(self.arm.heard["measured_js"].header.stamp.to_sec() - jump) < 2, 20, "stamps stay behind")
                self.arm.said.clear()
                ask(100)
                wait_for(lambda: any("too old, or lies in the future" in s for s in self.arm.said), 5, "an old stamp was taken")
                self.assertEqual(self.arm.state(), "ENABLED")
                self.assertLess(self.arm.off(here), 2e-3)
            self.arm.said.clear()
            ask(20)
            wait_for(lambda: any("held" in s for s in self.arm.said), 5, "a stamp of now was not taken: %s" % self.arm.said)
        finally:
            rospy.delete_param("/use_sim_time")

    def test_zz_what_is_connected_goes_on_without_a_master(self):  # the last one: it takes the master away
        self.enabled()
        stop(self.master, signal.SIGKILL)
        goal = [0.2, -0.05, 0.13]
        self.arm.ask("move_jp", goal)
        wait_for(lambda: self.arm.off(goal) < 3e-3, 20, "is %s" % self.arm.joints())
        time.sleep(2.5)
        node = self.processes[0]
        node.send_signal(signal.SIGINT)
        self.assertEqual(node.wait(20), 0)
        said = [line for line in node.stderr.read().splitlines() if "master" in line]
        self.assertEqual(len(said), 1, said)
        self.assertIn("what is connected goes on without a master", said[0])

    def test_bad_parameters_are_told_in_one_line(self):
        node = self.run_node("controller", arms=["PSM1"], PSM1__model="psm-3dfo")
        self.assertEqual(node.wait(20), 3)
        said = node.stderr.read().strip().splitlines()
        self.assertEqual(len(said), 1, said)
        self.assertIn("psm-3dof", said[0])


class NoMaster(unittest.TestCase):
    def test_is_told_at_once(self):
        environment = dict(os.environ, ROS_MASTER_URI="http://127.0.0.1:%d" % free_port())
        node = subprocess.run([os.path.join(BIN, "veridyn_controller")], env=environment, capture_output=True,
                              text=True, timeout=20)
        self.assertEqual(node.returncode, 3)
        self.assertRegex(node.stderr, r"^veridyn_controller: found no master at ")


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1] + sys.argv[3:], verbosity=2, warnings="ignore")
