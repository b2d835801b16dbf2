"""The linear programme of the best rule on cells of the circle, solved also where its optimum is degenerate."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_matrix, eye, hstack, vstack

from cyclemap.errors import ConvergenceError, InvalidInput

Array = NDArray[np.float64]

# Of HiGHS, on rows and reduced costs, and its iterations a row: solved programmes take seven.
_TOLERANCE, _ITERATIONS = 1e-10, 50
# Where a rule keeps the law even the optimum is degenerate, and simplex steps go in a circle: interior points then.
_ATTEMPTS = (("highs", _TOLERANCE), ("highs-ipm", 100.0 * _TOLERANCE))
_UNSOLVED = (1, 4)  # SciPy's status: out of iterations, numerical trouble


def solved_programme(changes: Any, drags: Array, allowed: float | None, limit: float) -> Any:
    """Return SciPy's solution of the programme of the best rule: ν (P·N), then the excess a (N).

    No change, mass 1, Σ ν_i - a ≤ 1/N, then Σ a ≤ ε or Σ d ν ≤ D; least Σ a, or Σ d ν where ε is given.

    changes : (N, P·N), sparse: what one cycle changes. drags : (P, N), m. allowed : ε, or None. limit : D, m, or inf.
    Raises InvalidInput where no rule keeps the drag, ConvergenceError where neither simplex nor interior point ends.
    """
    count = drags.shape[1]
    one, nothing, costs = eye(count, format="csr"), np.zeros(count), np.append(drags.ravel(), np.zeros(count))
    excess = np.append(np.zeros(drags.size), np.ones(count))
    still = vstack([hstack([changes, csr_matrix((count, count))]), csr_matrix(1.0 - excess)])
    over = hstack([hstack([one] * drags.shape[0]), -one])
    limits = [(excess, allowed)] if allowed is not None else [(costs, limit)] if math.isfinite(limit) else []
    found = _minimised(
        excess if allowed is None else costs,
        A_ub=vstack([over, *(csr_matrix(row) for row, _ in limits)]).tocsr(),
        b_ub=np.concatenate([np.full(count, 1.0 / count), [most for _, most in limits]]),
        A_eq=still.tocsr(),
        b_eq=np.append(nothing, 1.0),
    )
    if found.status == 2:
        raise InvalidInput(f"no rule keeps the mean drag within {limit:g} m: allow a longer one")
    if found.status != 0:
        raise ConvergenceError(f"the linear programme on {count} cells was not solved: {found.message}")
    return found


def _minimised(costs: Array, **rows: Any) -> Any:
    """What the first attempt that ends finds, or the last one that did not."""
    from scipy.optimize import linprog

    found, most = None, _ITERATIONS * (len(rows["b_ub"]) + len(rows["b_eq"]))
    for method, tolerance in _ATTEMPTS:
        options = {"primal_feasibility_tolerance": tolerance, "dual_feasibility_tolerance": tolerance, "maxiter": most}
        found = linprog(costs, method=method, options=options, **rows)
        if found.status not in _UNSOLVED:
            break
    return found
