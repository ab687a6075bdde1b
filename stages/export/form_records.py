"""What the loops make follow what in the URDF, and the package of its meshes, as robot.json has them."""

from typing import Any

from stages.formats.urdf.form import UrdfForm
from stages.robot.linear_coupling import LinearCoupling


def form_records(form: UrdfForm) -> dict[str, Any]:
    """The tables `couplings` and `urdf`, where the URDF has any of that."""
    couplings = [_coupling(one) for one in form.couplings]
    package = {"urdf": {"package": form.package}} if form.package else {}
    return ({"couplings": couplings} if couplings else {}) | package


def _coupling(one: LinearCoupling) -> dict[str, Any]:
    """An exact one with the numbers of its <mimic>; of another one, which is fitted, six digits."""
    line = [one.multiplier, one.offset]
    return {
        "follower": one.follower,
        "driver": one.driver,
        "multiplier": line[0] if one.exact else _short(line[0]),
        "offset": line[1] if one.exact else _short(line[1]),
        "range": [_short(one.low), _short(one.high)],
        "error": 0.0 if one.exact else _short(one.error),
        "mimic": one.exact,
    }


def _short(value: float) -> float:
    """To six digits, and what is next to nothing as 0: the last digits differ between machines."""
    return float(f"{value:.6g}") + 0.0 if abs(value) > 1e-9 else 0.0
