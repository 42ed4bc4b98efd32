"""An environment for tests: points on a line that forces bring to the middle."""

import torch


class PointMasses:
    """Each has a place and a speed, is rewarded for being near 0, fails beyond 2, and has 50 steps of time."""

    def __init__(self, count: int = 64, seed: int = 0) -> None:
        self.num_envs, self.num_observations, self.num_actions, self.dt = count, 2, 1, 0.1
        self.observation_names, self.action_names = ("place", "speed"), ("force",)
        self.critic_names = self.observation_names
        self.action_range, self.images, self.muscle_shares = (-3.0, 3.0), None, None
        self._random = torch.Generator().manual_seed(seed)
        self.place, self.speed, self.age = torch.zeros(count), torch.zeros(count), torch.zeros(count)

    @property
    def critic_observation(self):
        return torch.stack([self.place, self.speed], dim=1)

    @property
    def log(self):
        return dict.fromkeys(("time", "completed", "speed", "return", "hardness", "push_hardness"), torch.zeros(()))

    def _start(self, which):
        drawn = torch.rand(2, self.num_envs, generator=self._random) * 2.0 - 1.0
        self.place = torch.where(which, drawn[0], self.place)
        self.speed = torch.where(which, drawn[1], self.speed)
        self.age = torch.where(which, torch.zeros_like(self.age), self.age)

    def reset(self):
        self._start(torch.ones(self.num_envs, dtype=torch.bool))
        return self.critic_observation

    def step(self, actions):
        force = actions[:, 0].clamp(-3.0, 3.0)
        self.speed = self.speed + self.dt * force
        self.place = self.place + self.dt * self.speed
        self.age = self.age + 1.0
        reward = torch.exp(-4.0 * self.place**2) - 0.01 * force**2
        failed, ended = self.place.abs() > 2.0, self.age >= 50.0
        self._start(failed | ended)
        return self.critic_observation, reward, failed, ended

    def tighten(self, decisions):
        """Nobody fails earlier than at first."""

    def state_dict(self):
        return {"place": self.place, "speed": self.speed, "age": self.age, "random": self._random.get_state()}

    def load_state_dict(self, state):
        self.place, self.speed, self.age = (state[name].clone() for name in ("place", "speed", "age"))
        self._random.set_state(state["random"])
