"""A small scenario in SCONE's text, with a model of its own: a trunk on two legs, each with a foot and two muscles."""

from pathlib import Path

LEG = """
	body {{
		name = leg_{s} mass = 8 inertia {{ x = 0.3 y = 0.02 z = 0.3 }}
		joint {{
			name = hip_{s} parent = trunk pos_in_parent {{ x = 0 y = -0.3 z = {z} }}
			pos_in_child {{ x = 0 y = 0.4 z = 0 }}
			limits {{ x = 0..0 y = 0..0 z = -60..90 }}
		}}
	}}
	body {{
		name = foot_{s} mass = 1.5 inertia {{ x = 0.004 y = 0.008 z = 0.008 }}
		joint {{
			name = ankle_{s} parent = leg_{s} pos_in_parent {{ x = 0 y = -0.45 z = 0 }}
			pos_in_child {{ x = -0.05 y = 0.04 z = 0 }}
			limit_stiffness = 200 limit_damping = 2 limits {{ x = 0..0 y = 0..0 z = -40..30 }}
		}}
	}}
	point_path_muscle {{
		name = calf_{s} max_isometric_force = 3000 optimal_fiber_length = 0.06 tendon_slack_length = 0.3
		pennation_angle = 0.3
		path [ {{ body = leg_{s} pos {{ x = -0.02 y = -0.05 z = 0 }} }}
			{{ body = foot_{s} pos {{ x = -0.1 y = 0 z = 0 }} }} ]
	}}
	point_path_muscle {{
		name = seat_{s} max_isometric_force = 2000 optimal_fiber_length = 0.12 tendon_slack_length = 0.15
		path [ {{ body = trunk pos {{ x = -0.09 y = -0.2 z = {z} }} }}
			{{ body = leg_{s} pos {{ x = -0.05 y = 0.22 z = 0 }} }} ]
	}}
	geometry {{ name = {s}_heel type = sphere radius = 0.03 body = foot_{s} pos {{ x = -0.08 y = -0.02 z = 0 }} }}
	geometry {{ name = {s}_toe type = sphere radius = 0.03 body = foot_{s} pos {{ x = 0.08 y = -0.02 z = 0 }} }}
	dof {{ name = thigh_{s} source = hip_rz_{s} range = -60..90 }}
	dof {{ name = foot_{s} source = ankle_rz_{s} range = -40..30 }}
"""
MODEL = (
    """model {
	material { name = floor static_friction = 0.9 dynamic_friction = 0.6 stiffness = 6000 damping = 1 }
	model_options { joint_stiffness = 1e6 joint_limit_stiffness = 500 }
	body { name = ground mass = 0 inertia { x = 0 y = 0 z = 0 } }
	body { name = trunk mass = 40 inertia { x = 2 y = 1 z = 1.5 } mesh { file = trunk.vtp } }
	geometry { name = floor type = plane body = ground normal { x = -1 y = 0 z = 0 } ori { x = 0 y = 0 z = -90 } }
	dof { name = tilt source = trunk_rz } dof { name = trunk_x source = trunk_tx }
	dof { name = trunk_y source = trunk_ty }
"""
    + LEG.format(s="r", z=0.1)
    + LEG.format(s="l", z=-0.1)
    + "}\n"
)
CONTROLLER = """
# Two kinds of reflexes in stance, two in swing
GaitStateController {
	stance_load_threshold = ~0.1<0.001,1>
	symmetric = 1
	ConditionalControllers {
		ConditionalController {
			states = "EarlyStance LateStance Liftoff"
			ReflexController {
				MuscleReflex { target = calf delay = 0.020 KF = ~1.2<-10,10> C0 = 0.05 }
				Reflexes {
					DofReflex { target = seat source = tilt delay = 0.005 KP = ~1.9<-10,10> KV = 0.4 P0 = -0.1 }
				}
			}
		}
		ConditionalController {
			states = "Swing Landing"
			ReflexController {
				MuscleReflex { target = seat source = calf delay = 0.01 KL = ~2<-10,10> L0 = 0.7 KV = 0.1 }
				ConditionalMuscleReflex { target = calf delay = 0.01 C0 = 0.02 KF = 0.7
					dof = foot pos_max = ~-0.1<-1,1> }
			}
		}
	}
}
"""
SENSES = """
CompositeController {
	GaitStateController {
		symmetric = 0 stance_load_threshold = ~0.1<0.001,1>
		ConditionalControllers {
			ConditionalController {
				states = "EarlyStance LateStance Liftoff Swing Landing"
				ReflexController {
					BodyPointReflex { target = calf source = trunk offset [ 0.1 0.2 0 ] direction [ 0 0.5 0 ]
						delay = 0.01 KP = ~1.5<-10,10> P0 = 0.65 KV = -0.3 V0 = 0.2
						KA = ~0.004<-1,1> A0 = 1.5 C0 = 0.3 }
					BodyOrientationReflex { target = seat source = leg_o axis [ 0 0 1 ] delay = 0.005
						KP = ~0.5<-10,10> P0 = 0.4 KV = 0.02 C0 = 0.25 allow_neg_V = 0 }
				}
			}
			ConditionalController {
				states = "EarlyStance LateStance Liftoff" legs = right
				ReflexController {
					ComPivotReflex { target = seat pivot_body = foot dir [ 1 0 0 ] delay = 0.015 KP = ~-0.7<-10,10>
						KV = -0.1 V0 = 0.5 }
				}
			}
			ConditionalController {
				states = "Swing Landing"
				FeedForwardController { include = "cal*" PieceWiseLinear {
					control_points = 3 control_point_y = ~0.2<0,1> control_point_dt = 0.05~0.01<0.01,1> } }
			}
		}
	}
	ReflexController { ComPivotReflex { target = calf dir [ 1 0 0 ] KP = -0.8 P0 = 0.05 allow_neg_P = 0 KV = -0.05 } }
}
"""
SPINDLES = """
MirrorController {
	ReflexController {
		MuscleReflex { target = calf delay = 0.01 KS = ~0.4<-1,1> S0 = 0.9 C0 = 0.2 }
		MuscleReflex { target = calf source = seat KS = ~-0.3<-1,1> S0 = 0.4 allow_neg_S = 1 C0 = 0.05 }
		MuscleReflex { target = seat source = calf delay = 0.005 KA = ~-0.6<-2,2> A0 = 0.25 C0 = 0.5 KL = 0.2 L0 = 1 }
	}
}
"""
MOTOR = """
	body { name = chest mass = 20 inertia { x = 0.8 y = 0.4 z = 0.8 }
		joint { name = back parent = trunk pos_in_parent { x = 0 y = 0.3 z = 0 } pos_in_child { x = 0 y = -0.3 z = 0 }
			limits { x = 0..0 y = 0..0 z = -60..60 } limit_stiffness = 30 } }
	joint_motor { name = back_motor joint = back max_torque = 900 stiffness = 5 damping = 20 target_ori = [ 0 0 0 ] }
	dof { name = back_bends source = back_rz } dof { name = back_leans source = back_rx }
	geometry { name = belly type = capsule radius = 0.1 height = 0.2 body = chest rame = odd }
}
"""  # a body on the trunk, in place of the bracket that closes a model
UPRIGHT = """
$nerve = 0.005
ReflexController {
	name = posture dual_sided = 0
	BodyOrientationReflex { target = back_bends source = chest delay = $nerve KP = ~150<0,500> KV = 20
		P0 = -0.1~0.001<-0.5,0.5> }
	BodyOrientationReflex { target = back_leans source = chest axis = [ 1 0 0 ] KP = ~90<0,500> KV = ~9<0,50> P0 = 0 }
}
"""
NOISE = "NoiseController { base_noise = 0.05 random_seed = 7 }"
SCENARIO = """
CmaOptimizer {
	min_progress = 1e-4
	SimulationObjective {
		max_duration = 0.8
		auto_std_factor = 0.02
		ModelHyfydy {
			model_file = data/pair.hfd
			state_init_file = data/start.zml
			initial_state_offset = 0~0.01<-0.5,0.5>
			initial_state_offset_exclude = "*_x;*_y;*_u"
			fixed_control_step_size = 0.005
		}
		<< data/controller.scone >>
		CompositeMeasure {
			GaitMeasure { weight = 100 termination_height = 0.5 min_velocity = 1 }
			EffortMeasure { weight = 0.1 measure_type = Wang2012 use_cost_of_transport = 1 }
		}
	}
}
"""
START = """
values { tilt = -0.05 thigh_r = 0.35 foot_r = 0.05 thigh_l = -0.15 foot_l = 0.02 }
velocities { tilt = -0.1 trunk_x = 1.1 thigh_r = -1.5 thigh_l = 0.8 }
"""


def with_noise(controller: str = SENSES) -> str:
    """A composite controller with noise of its excitations."""
    return controller.rstrip().removesuffix("}") + NOISE + " }\n"


def with_chest(controller: str = CONTROLLER, model: str = MODEL) -> dict[str, str]:
    """Texts of a scenario whose trunk carries a chest, which a motor holds upright."""
    return {
        "controller": f"CompositeController {{ {controller} {UPRIGHT} }}",
        "model": model.rstrip().removesuffix("}") + MOTOR,
    }


def write(folder: Path, scenario: str = SCENARIO, controller: str = CONTROLLER, model: str = MODEL) -> Path:
    """Write the scenario and what it names into a folder; the path of the first."""
    (folder / "data").mkdir(exist_ok=True)
    for name, text in (
        ("pair.scone", scenario), ("data/controller.scone", controller), ("data/pair.hfd", model),
        ("data/start.zml", START),
    ):  # fmt: skip
        (folder / name).write_text(text)
    return folder / "pair.scone"
