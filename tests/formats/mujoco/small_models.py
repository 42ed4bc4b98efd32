"""Small models of MuJoCo of our own making, each with some of what a reader must keep."""

ARM = """<mujoco model="arm">
  <option timestep="0.001"/>
  <default><joint armature="0.02" damping="0.1" limited="true" range="-1 1.2"/></default>
  <worldbody>
    <site name="o1" pos="0.02 0.03 0.42"/> <site name="o2" pos="-0.05 0.02 0.4"/>
    <body name="upper" pos="0 0 0.4" euler="10 20 30">
      <inertial pos="0.01 0 -0.15" mass="2" fullinertia="0.02 0.021 0.004 0.001 0.0005 -0.0007"/>
      <joint name="flexion" axis="0 1 0"/> <joint name="rotation" axis="0 0.2 1" pos="0.01 0 0"/>
      <geom name="roll" type="cylinder" size="0.025 0.1" euler="90 0 0" pos="0 0 -0.05" mass="0"/>
      <site name="u1" pos="0.03 0.01 -0.1"/> <site name="u2" pos="-0.02 0 -0.2"/> <site name="beside"
        pos="0.06 0 -0.05"/>
      <body name="carriage" pos="0 0 -0.3">
        <inertial pos="0 0 0" mass="0.3" diaginertia="0.001 0.001 0.001"/>
        <joint name="elbow" axis="0 1 0.1"/>
        <joint name="shift" type="slide" axis="1 0 0.3" range="-0.1 0.1"/> <joint name="twist" axis="1 0 0"/>
        <geom name="ball" type="sphere" size="0.03" pos="-0.02 0 0.02" mass="0"/>
        <geom name="ring" type="sphere" size="0.05" pos="0.05 0.01 0.03" mass="0"/> <site name="within"
          pos="0.06 0.01 0.03"/>
        <site name="c1" pos="0.02 0 -0.03"/>
        <body name="plate" pos="0.02 0 0" euler="0 30 0"><inertial pos="0 0.02 0" mass="0.2"
          diaginertia="1e-3 2e-3 3e-3"/>
          <site name="p1" pos="0.05 0 -0.1"/></body>
        <body name="hand" pos="0 0 -0.25"><inertial pos="0.02 0 -0.03" mass="0.4" diaginertia="0.001 0.002 0.003"/>
          <joint name="wrist" axis="1 0 0" stiffness="3" springref="0.2"/> <site name="h1" pos="0.01 0.02 -0.02"/>
            </body>
      </body>
    </body>
  </worldbody>
  <equality>
    <joint joint1="shift" joint2="elbow" polycoef="0.002 0.01 -0.02 0.005 0.003"/>
    <joint joint1="twist" joint2="elbow" polycoef="0 0.8 -0.9 0.3 0"/>
  </equality>
  <tendon>
    <spatial name="front"><site site="o1"/><geom geom="roll" sidesite="beside"/><site site="u1"/><site site="c1"/>
      </spatial>
    <spatial name="back"><site site="o2"/><site site="u2"/><geom geom="ball"/><site site="p1"/><site site="h1"/>
      </spatial>
    <spatial name="hole"><site site="u1"/><geom geom="ring" sidesite="within"/><site site="h1"/></spatial>
    <spatial name="strap" stiffness="400" springlength="0 0.1"><site site="u2"/><site site="c1"/></spatial>
    <fixed name="belt"><joint joint="wrist" coef="0.02"/><joint joint="elbow" coef="-0.03"/></fixed>
  </tendon>
  <actuator>
    <muscle name="front" tendon="front" force="500" range="0.6 1.4" lengthrange="0.3 0.6" lmin="0.4" lmax="1.7"/>
    <muscle name="back" tendon="back" force="300" range="0.7 1.2" lengthrange="0.4 0.8" vmax="5" fpmax="2"
      gear="1.5"/>
    <muscle name="hole" tendon="hole" force="-1" scale="30" lengthrange="0.2 0.5" timeconst="0.015 0.05"/>
    <muscle name="belt" tendon="belt" force="200" lengthrange="-0.1 0.1"/>
    <muscle name="flexor" joint="flexion" force="10" lengthrange="-1 1.2" gear="1"/>
  </actuator>
</mujoco>"""

HOPPER = """<mujoco model="hopper">
  <worldbody>
    <geom name="floor" type="plane" size="5 5 1" pos="0 0 -0.1"/>
    <body name="base" pos="0 0 1"><freejoint name="root"/>
      <body name="trunk" pos="0 0 0.2" euler="20 0 0"><inertial pos="0 0.01 0.1" mass="5"
        diaginertia="0.1 0.08 0.05"/>
        <site name="t1" pos="0.05 0 0"/></body>
      <body name="pelvis"><inertial pos="0 0 0" mass="2" diaginertia="0.02 0.02 0.01"/>
        <body name="leg" pos="0 0.1 -0.1"><joint name="hip" axis="1 0 0" armature="0.01" ref="0.3"/>
          <geom type="capsule" fromto="0 0 0 0 0 -0.4" size="0.04" mass="2"/> <site name="l1" pos="0.05 0 -0.2"/>
          <body name="foot" pos="0 0 -0.4"><joint name="ankle" axis="1 0 0" damping="0.3" range="-60 60"
            limited="true"/>
            <geom type="sphere" size="0.05" pos="0 0.02 -0.02" mass="0.5" friction="0.6"/>
            <geom type="ellipsoid" size="0.05 0.1 0.02" mass="0.1"/> <site name="f1" pos="0.04 0.05 -0.02"/></body>
              </body>
      </body>
    </body>
  </worldbody>
  <tendon><spatial name="long"><site site="t1"/><site site="l1"/><site site="f1"/></spatial></tendon>
  <actuator><muscle name="long" tendon="long" force="400" lengthrange="0.5 0.9"/></actuator>
  <keyframe><key name="start" qpos="0.1 0.2 0.9 0.8 0.6 0 0 0.25 0.1" qvel="1 2 3 0.1 0.2 0.3 0.4 0.5"/></keyframe>
</mujoco>"""
