"""The oil's temperature: a slow state, warmed by what the machine loses, cooled by the air around it.

| symbol | name | unit |
|---|---|---|
| T, T_a | temperature of all oil, of the ambient | K |
| W | power that the machine turns into heat | W |
| m c | heat capacity of the oil | J/K |
| h | heat loss coefficient | W/K |

    m c dT/dt = W - h (T - T_a)

Its time constant m c/h is minutes, the plant's are milliseconds: they are stepped in turn. A
simulation runs the plant for UPDATE_PERIOD with what `parameters_at` gives, takes the mean of
`dissipated_power` over it, and asks `temperature_after` for the next temperature. Pressures and flows are
carried over as they are. The metal's heat is not counted: a machine warms slower than its oil
alone. The thesis has no temperature.
"""

import math
from collections.abc import Callable

from forest_description.derived.temperature import at_temperature
from forest_description.hydraulics.oil import COLDEST, HOTTEST, Oil
from forest_description.machine import Machine
from forest_sim.equations.plant_parameters import PlantParameters, parameters_of
from forest_sim.solver.integrator import Simulation
from forest_sim.solver.power_flows import PowerFlows, power_flows

UPDATE_PERIOD = 1.0  # [s] of simulated time, in which a machine at full loss warms by a quarter of a degree
LOSS_SAMPLES = 10  # of the power that warms the oil, in an update


def dissipated_power(flows: PowerFlows) -> float:
    """Return W [W]: what the engine gives, less what is stored and less the work on links and end stops.

    All of it is taken to warm the oil: friction of seals, gears and pump too.
    """
    axes, pump = (flows.swing, flows.boom, flows.stick), flows.pump
    work = sum(axis.joint + axis.stop + axis.hose + axis.elastic for axis in axes)
    return pump.engine - pump.manifold - pump.flywheel - pump.tank_line - work


def temperature_rate(temperature: float, loss_power: float, oil: Oil) -> float:
    """Return dT/dt [K/s] = (W - h (T - T_a))/(m c).

    Args:
        temperature: T [K].
        loss_power: W [W].
        oil: of the machine; its mass is the same at any reference temperature.
    """
    lost = oil.heat_loss_coefficient * (temperature - oil.ambient_temperature)
    return (loss_power - lost) / oil.heat_capacity


def temperature_after(temperature: float, loss_power: float, oil: Oil, time: float) -> float:
    """Return the temperature [K] after a time [s] of constant loss; exact, so that no time is too long.

    Args:
        temperature: T at the beginning [K].
        loss_power: W [W], the mean over the time.
        oil: as in `temperature_rate`.
        time: [s].
    """
    x = oil.heat_loss_coefficient * time / oil.heat_capacity
    fading = -math.expm1(-x) / x if x > 0.0 else 1.0
    return temperature + temperature_rate(temperature, loss_power, oil) * time * fading


def parameters_at(machine: Machine, temperature: float) -> PlantParameters:
    """Return the kernel's parameters of a machine with its oil at a temperature [K].

    Beyond the temperatures for which there are laws of the oil, they are those at the nearest one:
    a run does not end because a machine boils. They are not kept: none comes twice.
    """
    return parameters_of(at_temperature(machine, min(HOTTEST, max(COLDEST, temperature))))


class WarmingOil:
    """The oil of a machine that runs period by period.

    Args:
        oil: of the machine.
        period: [s].
    """

    def __init__(self, oil: Oil, period: float) -> None:
        self.temperature = oil.reference_temperature  # [K]
        self._oil, self._periods_per_update = oil, round(UPDATE_PERIOD / period)
        self._periods = 0
        self._losses: list[float] = []  # [W]

    def has_warmed(self, simulation: Callable[[], Simulation], p: PlantParameters) -> bool:
        """Tell after a period whether the temperature is another by now: it is every `UPDATE_PERIOD`.

        Args:
            simulation: gives where the machine is; asked `LOSS_SAMPLES` times in an update.
            p: its parameters over the period.
        """
        self._periods += 1
        if self._periods % (self._periods_per_update // LOSS_SAMPLES):
            return False
        self._losses.append(dissipated_power(power_flows(simulation(), p)))
        if self._periods % self._periods_per_update:
            return False
        mean = sum(self._losses) / len(self._losses)
        self._losses.clear()
        self.temperature = temperature_after(self.temperature, mean, self._oil, UPDATE_PERIOD)
        return True
