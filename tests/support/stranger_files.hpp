#pragma once

namespace veridyn {

/// An arm as others write it in MJCF: degrees, nested classes, all notations of a rotation, two
/// joints on one body, bodies of geoms, couplings, springs, tendons, servos.
inline const char* const kStrangerMjcf = R"(<mujoco model="stranger">
  <compiler angle="degree" eulerseq="XYz" autolimits="true"/>
  <option gravity="0.5 0 -9.7"/>
  <default>
    <joint damping="0.2" armature="0.01"/>
    <geom density="800"/>
    <default class="strong">
      <joint axis="0 1 0" frictionloss="0.4" range="-90 100"/>
      <motor gear="20" ctrlrange="-2 2"/>
      <default class="weak">
        <joint damping="0.05" frictionloss="0"/>
      </default>
    </default>
  </default>
  <worldbody>
    <geom type="plane" size="1 1 0.1"/>
    <body name="base" pos="0.1 0 0.2" euler="10 20 30">
      <geom type="box" size="0.1 0.1 0.1"/>
      <body name="upper" pos="0 0 0.3" axisangle="1 1 0 25" childclass="strong">
        <joint name="yaw" axis="0 0 2" pos="0.02 0.01 0"/>
        <joint name="pitch" pos="0 0 0.05" ref="15" stiffness="3" springref="20"/>
        <inertial pos="0.05 0 0.1" mass="2.5" fullinertia="0.03 0.02 0.025 0.001 0.002 -0.001"/>
        <site name="mark" pos="0.1 0.1 0" zaxis="1 2 3"/>
        <body name="fore" pos="0.2 0 0.3" xyaxes="0 1 0.1 -1 0 0">
          <joint name="elbow" class="weak"/>
          <geom type="capsule" fromto="0 0 0 0.3 0.05 0" size="0.03"/>
          <geom type="box" pos="0.1 0 0.02" quat="0.9 0.1 0.2 0.3" size="0.02 0.03 0.05" mass="0.4"/>
          <body name="slider" pos="0.3 0.05 0" zaxis="0.2 -1 0.3">
            <joint name="reach" type="slide" axis="0 0 1" range="-0.1 0.2" class="main"/>
            <geom type="cylinder" size="0.02 0.06"/>
            <geom type="ellipsoid" pos="0 0.01 0.1" size="0.02 0.03 0.04"/>
            <geom size="0.03" pos="0 0 0.2" group="1"/>
            <body name="finger" pos="0 0.02 0.1" quat="0.7 0 0.7 0.1">
              <joint name="follower" type="slide" axis="0 1 0" class="main" ref="0.01"/>
              <inertial pos="0 0 0.01" mass="0.1" diaginertia="1e-4 2e-4 1.5e-4" euler="0 30 0"/>
            </body>
          </body>
        </body>
      </body>
    </body>
  </worldbody>
  <equality><joint joint1="follower" joint2="reach" polycoef="0.02 -0.5 0 0 0"/></equality>
  <tendon><fixed name="belt" damping="0.7" stiffness="4"><joint joint="yaw" coef="1"/><joint joint="pitch" coef="-0.5"/></fixed></tendon>
  <actuator>
    <motor name="a" joint="yaw" class="strong"/>
    <position name="b" joint="pitch" kp="100" forcerange="-12 12"/>
    <motor name="c" joint="elbow" gear="5"/>
    <general name="d" joint="reach" biastype="affine" biasprm="1.5 0 0" forcerange="-3 3" gear="2"/>
  </actuator>
</mujoco>
)";

/// An arm as others write it in SDFormat: in a world, with poses relative to each other, an axis
/// expressed elsewhere, a spring, a link without values, an unlimited joint.
inline const char* const kStrangerSdf = R"(<?xml version="1.0"?>
<sdf version="1.9">
  <world name="hall">
    <gravity>0 0.3 -9.7</gravity>
    <model name="ground"><static>true</static><link name="plane"/></model>
    <model name="stranger">
      <pose>0.1 0.2 0.3 0.1 0.2 0.3</pose>
      <frame name="mount"><pose>0 0 0.1 0 0 0.4</pose></frame>
      <link name="base"><pose relative_to="mount">0 0 0.05 0 0 0</pose></link>
      <joint name="bolt" type="fixed"><parent>world</parent><child>base</child></joint>
      <joint name="swing" type="revolute">
        <pose relative_to="base">0.1 0 0.2 0.3 0 0</pose>
        <parent>base</parent><child>upper</child>
        <axis>
          <xyz expressed_in="mount">0 1 0.2</xyz>
          <limit><lower>-1.5</lower><upper>2</upper><effort>40</effort><velocity>3</velocity></limit>
          <dynamics><damping>0.3</damping><friction>0.7</friction><spring_stiffness>5</spring_stiffness><spring_reference>0.2</spring_reference></dynamics>
        </axis>
      </joint>
      <link name="upper">
        <pose relative_to="swing">0.02 0.03 0 0 0 0.5</pose>
        <inertial><pose>0.1 0 0.02 0.1 0 0</pose><mass>2</mass>
          <inertia><ixx>0.02</ixx><ixy>0.001</ixy><ixz>0</ixz><iyy>0.03</iyy><iyz>0.002</iyz><izz>0.025</izz></inertia></inertial>
      </link>
      <link name="fore">
        <pose relative_to="upper" degrees="true">0.3 0 0 90 0 20</pose>
        <inertial><mass>1.2</mass><inertia><ixx>0.01</ixx><iyy>0.012</iyy><izz>0.004</izz></inertia></inertial>
      </link>
      <joint name="slide" type="prismatic">
        <pose>0 0.01 0 0 0.2 0</pose>
        <parent>upper</parent><child>fore</child>
        <axis><xyz>0 0 1</xyz><limit><lower>-1e16</lower><upper>1e16</upper><effort>-1</effort></limit></axis>
      </joint>
      <frame name="flange" attached_to="fore"><pose rotation_format="quat_xyzw">0 0 0.1  0 0 0.7071067811865476 0.7071067811865476</pose></frame>
      <joint name="spin" type="continuous">
        <pose relative_to="flange"/>
        <parent>fore</parent><child>tool</child>
        <axis><xyz>0 0 1</xyz></axis>
      </joint>
      <link name="tool"><pose relative_to="flange">0 0 0.05 0 0 0</pose></link>
    </model>
  </world>
</sdf>
)";

}  // namespace veridyn
