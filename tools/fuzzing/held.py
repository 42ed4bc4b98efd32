"""A small OpenSim model with what holds bodies together, and one of MuJoCo: seeds of mutations."""

HELD = """<?xml version="1.0" encoding="UTF-8"?>
<OpenSimDocument Version="40500"><Model name="held">
<BodySet name="bodyset"><objects>
<Body name="one"><mass>2</mass><mass_center>0.1 0.2 0</mass_center><inertia>1 2 2 0 0 0</inertia></Body>
<Body name="two"><mass>1</mass><mass_center>0 -0.3 0.1</mass_center><inertia>1 2 2 0 0 0</inertia></Body>
</objects></BodySet>
<JointSet name="jointset"><objects>
<FreeJoint name="first"><socket_parent_frame>/ground</socket_parent_frame>
<socket_child_frame>/bodyset/one</socket_child_frame></FreeJoint>
<UniversalJoint name="second"><socket_parent_frame>/bodyset/one</socket_parent_frame>
<socket_child_frame>/bodyset/two</socket_child_frame><coordinates><Coordinate name="a"><range>-1 1</range></Coordinate>
<Coordinate name="b"><default_value>0.2</default_value></Coordinate></coordinates></UniversalJoint>
</objects></JointSet>
<ControllerSet name="controllerset"><objects><PrescribedController name="told">
<socket_actuators>/forceset/push /forceset/twist</socket_actuators>
<FunctionSet name="ControlFunctions"><objects><LinearFunction name="push"><coefficients>2 0.5</coefficients>
</LinearFunction><SimmSpline name="twist"><x>0 0.5 1</x><y>0 3 1</y></SimmSpline></objects></FunctionSet>
</PrescribedController></objects></ControllerSet>
<ForceSet name="forceset"><objects>
<Blankevoort1991Ligament name="cruciate"><GeometryPath name="path"><PathPointSet><objects>
<PathPoint name="1"><socket_parent_frame>/bodyset/one</socket_parent_frame><location>0 0.2 0</location></PathPoint>
<PathPoint name="2"><socket_parent_frame>/bodyset/two</socket_parent_frame><location>0 -0.2 0</location></PathPoint>
</objects></PathPointSet></GeometryPath><linear_stiffness>2000</linear_stiffness>
<transition_strain>0.06</transition_strain><damping_coefficient>0.003</damping_coefficient>
<slack_length>0.3</slack_length></Blankevoort1991Ligament>
<Schutte1993Muscle_Deprecated name="old"><GeometryPath name="path"><PathPointSet><objects>
<PathPoint name="1"><socket_parent_frame>/bodyset/one</socket_parent_frame><location>0.1 0.2 0</location></PathPoint>
<PathPoint name="2"><socket_parent_frame>/bodyset/two</socket_parent_frame><location>0.1 -0.2 0</location></PathPoint>
</objects></PathPointSet></GeometryPath><max_isometric_force>400</max_isometric_force>
<optimal_fiber_length>0.2</optimal_fiber_length><tendon_slack_length>0.15</tendon_slack_length>
<time_scale>0.1</time_scale><activation1>7.6</activation1><activation2>1.5</activation2><damping>0.05</damping>
<SimmSpline name="active_force_length_curve"><x>0 0.4 0.7 1 1.3 1.6 2</x><y>0 0 0.8 1 0.7 0 0</y></SimmSpline>
<SimmSpline name="passive_force_length_curve"><x>-5 0.999 1 1.2 1.5 5</x><y>0 0 0 0.1 0.9 0.9</y></SimmSpline>
<tendon_force_length_curve><SimmSpline><x>-10 0 0.02 0.04 20</x><y>0 0 0.3 1.1 900</y></SimmSpline>
</tendon_force_length_curve></Schutte1993Muscle_Deprecated>
<ExpressionBasedCoordinateForce name="capsule"><coordinate>a</coordinate>
<expression>-20*q^3 - min(qdot, 2)*exp(-q)</expression></ExpressionBasedCoordinateForce>
<ExpressionBasedPointToPointForce name="band"><body1>one</body1><body2>two</body2><point1>0.3 0.1 -0.2</point1>
<point2>0.1 0.4 0.05</point2><expression>90*(d-0.2)^2 + 12*ddot</expression></ExpressionBasedPointToPointForce>
<PointToPointSpring name="spring"><socket_body1>/ground</socket_body1><socket_body2>/bodyset/two</socket_body2>
<stiffness>300</stiffness><rest_length>0.4</rest_length></PointToPointSpring>
<FunctionBasedBushingForce name="disc"><socket_frame1>/bodyset/one</socket_frame1>
<socket_frame2>/bodyset/two</socket_frame2><rotational_damping>0.5 0.6 0.7</rotational_damping>
<m_x_theta_x_function><SimmSpline><x>-1 0 1</x><y>-9 1 20</y></SimmSpline></m_x_theta_x_function>
<f_y_delta_y_function><PolynomialFunction><coefficients>9 0 2 3</coefficients></PolynomialFunction>
</f_y_delta_y_function></FunctionBasedBushingForce>
<ExpressionBasedBushingForce name="curved"><socket_frame1>/bodyset/one</socket_frame1>
<socket_frame2>/bodyset/two</socket_frame2><Mx_expression>30*theta_x^3 - 4*theta_y*delta_z</Mx_expression>
</ExpressionBasedBushingForce>
<PrescribedForce name="wind"><socket_frame>/bodyset/two</socket_frame><forceIsGlobal>true</forceIsGlobal>
<FunctionSet name="forceFunctions"><objects><Constant><value>3</value></Constant><LinearFunction>
<coefficients>1 2</coefficients></LinearFunction><Constant><value>0</value></Constant></objects></FunctionSet>
</PrescribedForce>
<PointActuator name="push"><body>two</body><point>0.1 0.3 -0.1</point><direction>1 2 -2</direction>
<optimal_force>60</optimal_force></PointActuator>
<TorqueActuator name="twist"><bodyA>two</bodyA><bodyB>one</bodyB><axis>0 1 0</axis></TorqueActuator>
</objects></ForceSet></Model></OpenSimDocument>
"""
ROBOT = """<mujoco model="robot">
  <worldbody><geom name="floor" type="plane" size="1 1 1"/>
    <body name="arm" pos="0 0 1"><inertial pos="0 0 -0.2" mass="1" diaginertia="0.1 0.1 0.1"/>
      <joint name="turn" axis="0 1 0" range="-60 60" limited="true" damping="0.1"/>
      <geom name="roll" type="cylinder" size="0.02 0.1" euler="90 0 0" mass="0"/><site name="s1" pos="0.05 0 -0.1"/>
      <body name="rod" pos="0 0 -0.4"><inertial pos="0 0 -0.1" mass="1" diaginertia="0.1 0.1 0.1"/>
        <joint name="push" type="slide" axis="0 0 1"/><site name="s2" pos="0.05 0 -0.1"/>
        <geom type="capsule" fromto="0 0 0 0 0 -0.2" size="0.02"/></body></body>
    <body name="other" pos="0.5 0 1"><inertial pos="0 0 -0.2" mass="1" diaginertia="0.1 0.1 0.1"/>
      <joint name="swing" axis="0 1 0"/><site name="s3" pos="0 0 -0.3"/></body>
  </worldbody>
  <equality><connect name="loop" body1="arm" body2="other" anchor="0.1 0 -0.3"/>
    <joint joint1="push" joint2="turn" polycoef="0 0.1 0 0 0"/></equality>
  <tendon><spatial name="rope"><site site="s1"/><geom geom="roll"/><site site="s2"/></spatial></tendon>
  <actuator>
    <muscle name="pull" tendon="rope" force="100" lengthrange="0.2 0.5"/>
    <motor name="motor" joint="turn" gear="-3" ctrllimited="true" ctrlrange="-0.5 2"/>
    <position name="servo" joint="swing" kp="40" forcelimited="true" forcerange="-6 9"/>
  </actuator>
  <keyframe><key name="start" qpos="0.1 0 0.1" ctrl="0.1 0.8 0.3"/></keyframe>
</mujoco>
"""
