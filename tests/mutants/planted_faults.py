"""Faults to plant, by the file they go into: signs, comparisons, dropped terms, tolerances, wrong
index, wrong seed.

Of each file the tests that must notice, the likeliest first, all of the file's own room; and the
faults: a text that stands in the file once, and what takes its place.
"""

Fault = tuple[str, str]
ENGINE = "tests/mechanics/test_published_numbers.py tests/mechanics/test_derivatives.py"
PRESSED = (
    "tests/mechanics/test_pressure.py tests/mechanics/test_foundation.py "
    "tests/mechanics/test_footprint.py"
)
CONTACTS = (
    "tests/mechanics/test_contact_curve.py tests/mechanics/test_contacts.py "
    "tests/mechanics/test_concave_objects.py"
)
LIFTS = "tests/maps/lifts"
NOISE = "tests/maps/test_noise_law.py tests/maps/operator/test_transfer_operator.py"
OPERATOR = "tests/maps/operator"
ORBITS = "tests/maps/orbits"
STAIRCASES = "tests/maps/staircases"
COLLECTION = "tests/collection/test_loop.py tests/collection"
LAWS = "tests/evidence/laws"
ORIENTATIONS = "tests/evidence/laws/test_circular_distance.py tests/evidence/comparison"
IDENTIFICATION = "tests/evidence/identification"
PUSHES, TABLES = "tests/evidence/pushes", "tests/evidence/tables"
DESIGN = "tests/resets/test_orientation_law.py tests/resets/test_strategy.py tests/resets"
MONITOR = "tests/resets/test_bias_evidence.py tests/resets/test_bias_monitor.py tests/resets"

FAULTS: dict[str, tuple[str, list[Fault]]] = {
    "mechanics/engine/ellipse.c": (
        f"{ENGINE} tests/mechanics/test_random_cases.py",
        [
            (
                "spin[M_YY] * middle[X] - spin[M_XY] * middle[Y]",
                "spin[M_YY] * middle[X] + spin[M_XY] * middle[Y]",
            ),
            ("e.far = p > omega;", "e.far = p < omega;"),
            ("sums->of[XY] += kx * ux;", "sums->of[XY] -= kx * ux;"),
            (
                "even * (ux * nx + uy * ny) + odd * steep",
                "even * (ux * nx + uy * ny) - odd * steep",
            ),
        ],
    ),
    "mechanics/engine/contact.c": (
        f"{ENGINE} tests/mechanics/test_contacts.py",
        [
            ("m.p[SMU] = SIGN[mode] * r->friction;", "m.p[SMU] = -SIGN[mode] * r->friction;"),
            ("return tangential - smu * normal;", "return tangential + smu * normal;"),
            (
                "f[FRAME_X] * gy - f[FRAME_Y] * gx - f[FRAME_TORQUE]",
                "f[FRAME_X] * gy - f[FRAME_Y] * gx",
            ),
            ("s->facing + M_PI - atan(tau)", "s->facing + M_PI + atan(tau)"),
        ],
    ),
    "mechanics/engine/cycle.c": (
        f"{ENGINE} tests/mechanics/test_drag.py tests/mechanics",
        [
            ("double longer = -(toward[X]", "double longer = (toward[X]"),
            (
                "before[c] + travel * toward[c] - after[c]",
                "before[c] - travel * toward[c] - after[c]",
            ),
            ("0.5 * by_ring[k][X] - centre[Y] * turn", "by_ring[k][X] - centre[Y] * turn"),
        ],
    ),
    "mechanics/engine/phase.c": (
        f"{ENGINE} tests/mechanics/test_random_cases.py tests/mechanics/test_two_contacts.py",
        [
            ("result[Y] = s * x + c * y;", "result[Y] = s * x - c * y;"),
            ("normal[Y] - share * normal[X]", "normal[Y] + share * normal[X]"),
            (
                "if (margin < 0.0)\n            high = h;",
                "if (margin > 0.0)\n            high = h;",
            ),
            (
                "found ? next_length(tried, taken->error, tolerance)",
                "found ? next_length(tried, taken->error, 1e4 * tolerance)",
            ),
        ],
    ),
    "mechanics/friction.py": (
        "tests/mechanics/test_friction.py tests/mechanics",
        [
            ("self.n0 / self.mu_b) >= 1.0", "self.n0 / self.mu_b) >= 2.0"),
            (
                "self.mu_b * v_n) + self.m0 * v_m + self.n0 * v_n",
                "self.mu_b * v_n) + self.m0 * v_m - self.n0 * v_n",
            ),
            ("self.m0 + self.mu_a**2 * v_m / s", "self.m0 + self.mu_a * v_m / s"),
            ("self.phi + angle)", "self.phi - angle)"),
            ("fx, fy, x * fy - y * fx", "fx, fy, x * fy + y * fx"),
            ("columns @ constant, values[:, 1:4] + constant", "columns @ constant, values[:, 1:4]"),
        ],
    ),
    "mechanics/footprint.py": (
        PRESSED,
        [
            ("self.corner_share * corners, -corners]", "0.0 * corners, -corners]"),
            ("even_share < -_ROUNDING", "even_share < -0.5"),
            (
                "(np.arange(count) + 0.5) / count\n    shares",
                "np.arange(count) / count\n    shares",
            ),
            ("weights = load * (1.0 + lever @ lean)", "weights = load * (1.0 - lever @ lean)"),
            ("centroid + INNER * (grid - centroid)", "centroid + 0.9 * (grid - centroid)"),
            (
                "points, weights = points[weights > 0.0], weights[weights > 0.0]",
                "points, weights = points, weights",
            ),
        ],
    ),
    "mechanics/contact_curve.py": (
        f"{CONTACTS} tests/mechanics",
        [
            ("self.x + radius * math.cos(self.normal)", "self.x - radius * math.cos(self.normal)"),
            ("speed + radius * turning", "speed + radius * turning * speed"),
            ("fraction * length, length", "(1.0 - fraction) * length, length"),
            ("if gap >= radius - rounding", "if gap >= 0.5 * radius - rounding"),
            ("math.atan2(-x, y), 0.0, length", "math.atan2(x, -y), 0.0, length"),
        ],
    ),
    "mechanics/outline.py": (
        f"tests/mechanics/test_footprint.py {CONTACTS} tests/mechanics",
        [
            (".sum(axis=0) / (6.0 * area) + points[0]", ".sum(axis=0) / (3.0 * area) + points[0]"),
            ("if area < 0.0:", "if area < -1.0:"),
            ("math.pi * a * b, extent", "math.pi * a * a, extent"),
            ("points[..., 1] / self.semi_y) < 1.0", "points[..., 1] / self.semi_x) < 1.0"),
        ],
    ),
    "mechanics/quasi_static.py": (
        f"{ENGINE} tests/mechanics/test_push_physics.py tests/mechanics",
        [
            ("contact.normal + math.pi + push.angle", "contact.normal + math.pi - push.angle"),
            ("push.distance / self.unit - max(travel, 0.0)", "push.distance / self.unit"),
            ("STEP_SHARE * self.accuracy", "1e4 * STEP_SHARE * self.accuracy"),
        ],
    ),
    "mechanics/slider.py": (
        "tests/mechanics/test_published_numbers.py tests/mechanics/test_parts.py tests/mechanics",
        [
            ("self.y + s * x + c * y", "self.y - s * x + c * y"),
            ("c * dx + s * dy, -s * dx + c * dy", "c * dx - s * dy, s * dx + c * dy"),
            (
                "(-0.015 / math.sqrt(2.0), 0.015 / math.sqrt(2.0))",
                "(0.015 / math.sqrt(2.0), 0.015 / math.sqrt(2.0))",
            ),
            ("< math.pi / 2.0:", "< math.pi:"),
        ],
    ),
    "maps/lifts/circle_map.py": (
        LIFTS,
        [
            ("lambda x: 1.0 - strength * np.cos(x)", "lambda x: 1.0 + strength * np.cos(x)"),
            ("return self._lift(angles) - angles", "return self._lift(angles)"),
            (
                "jumping = np.abs(right - left) > JUMP",
                "jumping = np.abs(right - left) > 1e6 * JUMP",
            ),
            (
                "slope = slope + top / (gap * gap + 2.0 * double * s * s)",
                "slope = slope + top / (gap * gap + double * s * s)",
            ),
        ],
    ),
    "maps/lifts/lift_checks.py": (
        LIFTS,
        [("LIFT * (1.0 + np.abs(slope))", "LIFT * 0.0 * (1.0 + np.abs(slope))")],
    ),
    "maps/lifts/map_algebra.py": (
        LIFTS,
        [
            ("error + np.max([np.abs(side - slope) for side in sides], axis=0)", "error"),
            ("+ error * (np.abs(slope) + off)\n", "\n"),
            ("return min(outer.max_error + steepest * error", "return min(outer.max_error + error"),
            (
                "turns = (turns + whole) * float(circle_map.degree)",
                "turns = 1.0 * (turns + whole)",
            ),
            (
                "lowest > 0.0, error / (np.abs(slope) * lowest), np.inf",
                "lowest > 0.0, error * lowest, np.inf",
            ),
            ("if degree * jump < -JUMP:", "if degree * jump < -1e9 * JUMP:"),
        ],
    ),
    "maps/lifts/piecewise_lifts.py": (
        f"{LIFTS} tests/maps/families",
        [
            (
                "c2 = (3.0 * secant - 2.0 * slope_left - slope_right) / width",
                "c2 = (3.0 * secant - slope_left - 2.0 * slope_right) / width",
            ),
            (
                "return np.asarray((3.0 * c3 * offset + 2.0 * c2) * offset + c1)",
                "return np.asarray((3.0 * c3 * offset + c2) * offset + c1)",
            ),
            ("if np.any(steps < 0.0):", "if np.any(steps < -1.0):"),
            ("if abs(gap) > SNAP:", "if abs(gap) > 1e6 * SNAP:"),
            (
                "np.concatenate([lifted[:-1] - climb, lifted, lifted[1:] + climb])",
                "np.concatenate([lifted[:-1], lifted, lifted[1:] + climb])",
            ),
        ],
    ),
    "maps/noise.py": (
        NOISE,
        [
            ("np.exp(-0.5 * (order * self.sigma) ** 2)", "np.exp(-(order * self.sigma) ** 2)"),
            ("self.r ** (m + 1) / (1.0 - self.r)", "self.r ** (m + 1)"),
            ("(1.0 - self.r**2) / (TWO_PI * distance)", "(1.0 - self.r) / (TWO_PI * distance)"),
            ("stretch = (1.0 + self.r) / (", "stretch = (1.0 + self.r) + 0.0 * ("),
            (
                "scaled = reals(x) / (self.sigma * math.sqrt(2.0))",
                "scaled = reals(x) / self.sigma",
            ),
        ],
    ),
    "maps/operator/poisson_equation.py": (
        OPERATOR,
        [
            ("bound = abs(value - rough) + rounding", "bound = rounding"),
            ("growth = 1.0 + self._growth", "growth = 1.0"),
            (
                "return self._own_error + float(np.max(self._density_moved))",
                "return self._own_error",
            ),
            ("correction = defect + once + fine.cycle(resolved)", "correction = defect + once"),
            ("added = turn * (0.5 * turn + later)", "added = turn * (turn + later)"),
            ("(np.abs(self.masses) @ slopes + epsilon * (bend + other))", "(epsilon * bend)"),
            ("epsilon * (bend + other)", "epsilon * bend"),
            ("(_MISSED * first + epsilon * second)", "(_MISSED * first)"),
            ("moved = epsilon * rate + max(beyond)", "moved = epsilon * rate"),
        ],
    ),
    "maps/operator/transfer_operator.py": (
        OPERATOR,
        [
            (
                "self.map.turn(theta) / TWO_PI, direct=1.0 / TWO_PI",
                "self.map.turn(theta), direct=1.0 / TWO_PI",
            ),
            ("abs(self._finer.diffusion() - plain) + plain.error_bound", "plain.error_bound"),
            ("max(0.0, 1.0 - second), second.error_bound", "max(0.0, second), second.error_bound"),
        ],
    ),
    "maps/operator/spectrum.py": (
        OPERATOR,
        [
            ("bounds += _moved_by_map(basis, right, left, apart, same)", "bounds += 0.0"),
            ("own + np.sum(others, axis=1, where=~same)", "own"),
        ],
    ),
    "maps/operator/fourier_basis.py": (
        OPERATOR,
        [
            (
                "max(self.modes, needed_modes(self.noise)), 2 * self.finer",
                "max(self.modes, needed_modes(self.noise)), self.finer",
            ),
            ("if work > MAX_WORK:", "if work > 1e9 * MAX_WORK:"),
            (
                "np.concatenate([constant, sines, -cosines])",
                "np.concatenate([constant, -sines, cosines])",
            ),
        ],
    ),
    "maps/orbits/periodic_points.py": (
        ORBITS,
        [
            ("flips = (left < 0.0) & (right < 0.0)", "flips = (left < 0.0) | (right < 0.0)"),
            (
                "unsure = np.maximum(NEUTRAL, np.where(slope_error < _TRUSTED, slope_error, 0.0))",
                "unsure = NEUTRAL",
            ),
            # The margin of the first bracket is no fault to plant: brackets widen until these hold.
            (
                "(np.abs(low) > low_noise + TANGENCY * touches)\n"
                "            & (np.abs(high) > high_noise + TANGENCY * touches)",
                "(np.abs(low) > TANGENCY * touches)\n            & (np.abs(high) > TANGENCY * touches)",
            ),
            (
                "broken = np.any(table < 0, axis=0)",
                "broken = np.any(table < -1, axis=0)",
            ),
            (
                "whole = whole - beyond * scan.lap",
                "whole = whole + 0 * beyond",
            ),
        ],
    ),
    "maps/orbits/orbit_means.py": (
        f"{ORBITS} tests/maps/families/test_long_orbits.py tests/maps/lifts/test_slope_errors.py",
        [
            (
                "return Estimate(mean, apart + MEAN * float(np.max(np.abs(sequence))))",
                "return Estimate(mean, 0.0 * apart)",
            ),
            ("weight = np.exp(-1.0 / (t * (1.0 - t)))", "weight = np.exp(-1.0 / t)"),
            (
                "else DEVIATIONS * spread + inexact",
                "else inexact",
            ),
            (
                "Estimate(mean, mean.error_bound + blurred.upper)",
                "Estimate(mean, mean.error_bound)",
            ),
            ("np.abs(means - mean))), 2.0 * spread)", "np.abs(means - mean))), 0.02 * spread)"),
            ("off = max(off, unseen)", "off = max(off, 0.0 * unseen)"),
        ],
    ),
    "maps/orbits/rotation_number.py": (
        ORBITS,
        [
            (
                "wanted = side * ((theta - start) + TWO_PI * (turns - ratio.numerator))",
                "wanted = side * (theta - start)",
            ),
            (
                "return base + 1 / simplest_between(1 / (high - base), 1 / (low - base))",
                "return base + 1 / simplest_between(1 / (low - base), 1 / (high - base))",
            ),
            ("whole = np.array(self.laps[1:]) + up", "whole = np.array(self.laps[1:])"),
        ],
    ),
    "maps/orbits/diagonal.py": (
        ORBITS,
        [
            (
                "float(n * np.pi / np.sqrt(bend * least))",
                "float(np.pi / np.sqrt(bend * least))",
            ),
            ("unknown = 0.5 * float(np.max(rounding)) / abs(passage.gap)", "unknown = 0.0"),
            (
                "true = float(np.dot(stretch, (1.0 - bend[:-2] ** 2 / 12.0) / g[:-2]))",
                "true = float(np.dot(stretch, 1.0 / g[:-2]))",
            ),
            ("lambda x: 0.5 * displacement", "lambda x: displacement"),
        ],
    ),
    "maps/families/tongues.py": (
        "tests/maps/families/test_tongues.py",
        [
            (
                "room = np.max(gap[:, 1:] if sign > 0.0 else gap[:, :-1], axis=1) + 0.25 * width",
                "room = np.max(gap[:, 1:] if sign > 0.0 else gap[:, :-1], axis=1)",
            ),
            ("(LIFT * angle * disturbed + unseen) / moved", "(LIFT * angle * disturbed) / moved"),
            ("if unseen == 0.0 or missed <= 0.0:", "if True:"),
            (
                "max(self.right - self.left, 0.0), self.left.error_bound + self.right.error_bound",
                "max(self.right - self.left, 0.0), self.left.error_bound",
            ),
            ("if q < 1 or gcd(p, q) != 1:", "if q < 1:"),
            (
                "noise = 2.0 * np.max(rounding, axis=1)",
                "noise = 1e9 * np.max(rounding, axis=1)",
            ),
        ],
    ),
    "maps/families/long_orbits.py": (
        "tests/maps/families/test_long_orbits.py tests/maps/lifts/test_slope_errors.py",
        [
            (
                "0.0, DEVIATIONS * spread / np.sqrt(_PARTS))",
                "0.0, spread / _PARTS)",
            ),
        ],
    ),
    "maps/staircases/slow_zones.py": (
        STAIRCASES,
        [
            ("TWO_PI * known.rotation_number.error_bound)", "0.0)"),
            (
                "float(starts @ of_all - starts[ring] @ of_missed)",
                "float(starts @ of_all)",
            ),
            (
                "spread = float(np.sqrt(max(square - mean**2, 0.0)))",
                "spread = float(np.sqrt(max(square, 0.0)))",
            ),
        ],
    ),
    "maps/staircases/drifting_map.py": (
        STAIRCASES,
        [
            ("np.sum(np.abs(np.diff(slopes)))) / 8.0", "0.0) / 8.0"),
            (
                "error = rest * before.max_error + share * after.max_error",
                "error = before.max_error",
            ),
            ("if error <= tolerance:", "if error <= 100.0 * tolerance:"),
        ],
    ),
    "maps/staircases/staircase.py": (
        STAIRCASES,
        [
            ("(1.0 + self.correlation) / (1.0 - self.correlation)", "1.0"),
            (
                "last = z[n] = rho * last + math.sqrt(1.0 - rho**2) * fresh[n]",
                "last = z[n] = rho * last + fresh[n]",
            ),
            (
                "path = sample_staircases(circle_map, noise, count, [begin], seed)[0]",
                "path = sample_staircases(circle_map, noise, count, [begin], 0)[0]",
            ),
        ],
    ),
    "maps/staircases/steps.py": (
        f"{STAIRCASES} tests/calibration/test_small_calibration.py",
        [
            ("return self.end - self.start + 1", "return self.end - self.start"),
            ("kept = inside[first] & (deep[last + 1] > deep[first])", "kept = inside[first]"),
            ("if max(contrast, default=0.0) < _CONTRAST:", "if max(contrast, default=0.0) < 0.0:"),
            ("within = 2.0 * float(np.mean(steps.scatter**2))", "within = 0.0"),
            (
                "alive = np.cumprod(1.0 - ended / at_risk)",
                "alive = np.cumprod(1.0 - ended / lengths.size)",
            ),
            (
                "return min(1.0, 2.0 * min(middle, 1.0 - middle))",
                "return min(1.0, min(middle, 1.0 - middle))",
            ),
            ("exposure / exits**1.5", "exposure / exits"),
        ],
    ),
    "collection/adaptive_map.py": (
        "tests/collection/test_adaptive_map.py",
        [
            ("+ _LOCATED * tolerance + sample_error", "+ _LOCATED * tolerance"),
            (
                "waiting = [*by_error[:_CHECKED], *spread]",
                "waiting = list[_Interval]()",
            ),
            (
                "_resolve(sampler, [_Interval(low, high, math.inf) for low, high in "
                "pairwise(ends)])",
                "_resolve(sampler, [_Interval(interval.low, interval.high, math.inf)])",
            ),
            ("if min(off) > _SIDE_SHARE * gap:", "if min(off) > 1e9 * gap:"),
            (
                "tangents = width * s * (1.0 - s) * ((1.0 - s) * low.slope - s * high.slope)",
                "tangents = width * s * (1.0 - s) * ((1.0 - s) * low.slope + s * high.slope)",
            ),
            ("is_jump = gap > 10.0 * sampler.tolerance", "is_jump = gap > 1e9 * sampler.tolerance"),
        ],
    ),
    "collection/loop.py": (
        COLLECTION,
        [
            (
                "sample_error = max(0.1 * tolerance, 1e-10)",
                "sample_error = max(100.0 * tolerance, 1e-10)",
            ),
            ("accuracy=min(sample_error, 1e-6)", "accuracy=1e-2"),
        ],
    ),
    "collection/uncertain_directions.py": (
        "tests/collection/test_uncertain_directions.py",
        [
            ("return self.locks / self.samples", "return self.locks / (self.samples + self.locks)"),
            (
                "ends = (0.0, 1.0) if span else (0.5 * (1.0 - LEVEL), 0.5 * (1.0 + LEVEL))",
                "ends = (0.0, 1.0) if span else (0.25, 0.75)",
            ),
            (
                "stable = _cubic_slope(cells[cell], share) > -2.0",
                "stable = _cubic_slope(cells[cell], share) < -2.0",
            ),
            (
                "h11 = share**2 * (share - 1.0)",
                "h11 = share**2 * (1.0 - share)",
            ),
        ],
    ),
    "collection/fingerprint.py": (
        "tests/collection/test_fingerprint.py",
        [
            (
                "hessians = 0.5 * (differences + differences.transpose(0, 2, 1))",
                "hessians = differences + differences.transpose(0, 2, 1)",
            ),
            (
                "return np.asarray(0.5 * np.sum((z @ self.hessian) * z, axis=-1))",
                "return np.asarray(np.sum((z @ self.hessian) * z, axis=-1))",
            ),
        ],
    ),
    "collection/loop_surfaces.py": (
        "tests/collection",
        [
            (
                "axis = friction.phi if signed >= 0.0 else friction.phi + 0.5 * math.pi",
                "axis = friction.phi",
            ),
            (
                "np.exp(2j * (self.ellipse_direction - angle))",
                "np.exp(1j * (self.ellipse_direction - angle))",
            ),
            (
                "shares = first + (last - first) * blend.cycles / max(steps - 1, 1)",
                "shares = last + (first - last) * blend.cycles / max(steps - 1, 1)",
            ),
        ],
    ),
    "evidence/laws/linear_fit.py": (
        LAWS,
        [
            (
                "window = 1.0 - np.abs(np.arange(-lags, lags + 1)) / (lags + 1.0)",
                "window = np.ones(2 * lags + 1)",
            ),
            (
                "covariance = inverse @ total @ inverse * (count / (count - unknowns))",
                "covariance = inverse @ total @ inverse",
            ),
            (
                "return float(stdtrit(freedom, 0.5 + 0.5 * probability))",
                "return float(stdtrit(freedom, probability))",
            ),
            ("residuals / (value.size - unknowns)", "residuals / value.size"),
            ("reached = leverage <= 1.0", "reached = leverage >= 0.0"),
            (
                "good = np.flatnonzero(mean - mean[best] <= spread + floor)",
                "good = np.flatnonzero(mean - mean[best] <= floor)",
            ),
            (
                "np.random.default_rng(seed).permutation(np.arange(blocks) % FOLDS)",
                "np.arange(blocks) % FOLDS",
            ),
        ],
    ),
    "evidence/laws/periodic_law.py": (
        LAWS,
        [
            (
                "np.cos(multiples) @ (order * self.sine) - np.sin(multiples) @ (order * "
                "self.cosine)",
                "np.cos(multiples) @ (order * self.sine) + np.sin(multiples) @ (order * "
                "self.cosine)",
            ),
            (
                "return quantile * error, quantile * np.hypot(error, self.noise(theta))",
                "return quantile * error, quantile * self.noise(theta)",
            ),
            ("gamma[0] += np.log(value.size / (value.size - design.shape[1]))", "gamma[0] += 0.0"),
            ("np.exp(0.5 * (columns @ self.log_variance))", "np.exp(columns @ self.log_variance)"),
        ],
    ),
    "evidence/laws/fit_map.py": (
        LAWS,
        [
            (
                "scaled = np.clip((2.0 * cycles - first - last) / (last - first), -1.0, 1.0)",
                "scaled = (2.0 * cycles - first - last) / (last - first)",
            ),
            (
                "images = angles + _without_jumps(angles, images)",
                "images = angles + (images - angles)",
            ),
            ("law(theta) + law.noise(theta) * rng", "law(theta) + 0.0 * rng"),
        ],
    ),
    "evidence/laws/circular_distance.py": (
        ORIENTATIONS,
        [
            (
                "np.max(rank[1:] - reached, axis=-1) + np.max(reached - rank[:-1], axis=-1)",
                "np.max(rank[1:] - reached, axis=-1)",
            ),
            (
                "size * np.var(excess, axis=-1) + 1.0 / (12.0 * size)",
                "size * np.mean(excess**2, axis=-1) + 1.0 / (12.0 * size)",
            ),
            (
                "return PValue((1 + reached) / (null.size + 1)",
                "return PValue(reached / (null.size + 1)",
            ),
            (
                "np.asarray(0.5 * np.sum(np.abs(shares - against), axis=-1))",
                "np.asarray(np.sum(np.abs(shares - against), axis=-1))",
            ),
            (
                "median = levels[order[np.argmax(np.cumsum(gaps[order]) >= np.pi)]]",
                "median = levels[order[0]]",
            ),
        ],
    ),
    "evidence/comparison/collection_null.py": (
        ORIENTATIONS,
        [
            ("seed + _APART * (index + 1)", "seed"),
            ("worn.cycles - self.first", "worn.cycles"),
            (
                "np.abs(climb(paths) - np.mean(climb(ensemble.paths))) / TWO_PI",
                "np.abs(climb(paths)) / TWO_PI",
            ),
        ],
    ),
    "evidence/comparison/cycle_agreement.py": (
        "tests/evidence/comparison",
        [
            ("explained / rank * free / left", "explained * free / left"),
            (
                "monte_carlo_p_value(abs(value - centre), np.abs(known - centre))",
                "monte_carlo_p_value(value, known)",
            ),
        ],
    ),
    "evidence/comparison/push_agreement.py": (
        "tests/evidence/comparison",
        [
            (
                "critical = 1.96 + 2.9694 * share + 0.416 * share**2 - 0.5324 * share**3",
                "critical = 1.96",
            ),
            ("share = (window_lags(count) + 1.0) / count", "share = min(1.0, 1.3 / count**0.5)"),
        ],
    ),
    "evidence/identification/least_squares.py": (
        IDENTIFICATION,
        [
            (
                "float(np.sum(self.law.loss((residuals / size) ** 2)[0]) + 2.0 * "
                "np.sum(np.log(size)))",
                "float(np.sum(self.law.loss((residuals / size) ** 2)[0]))",
            ),
            (
                "(self.freedom + 1.0) / (self.freedom + z)",
                "(self.freedom + 1.0) / (self.freedom + 1.0)",
            ),
            (
                "redundancy = np.bincount(index, 1.0 - leverage, len(names))",
                "redundancy = np.bincount(index, 1.0 + 0.0 * leverage, len(names))",
            ),
            ("best = min(fits, key=lambda fit: fit.deviance)", "best = fits[0]"),
            ("read_only(np.where(blind, np.inf, error * scale))", "read_only(error * scale)"),
            (
                "covariance = sandwich + by_weights + believed.T @ believed",
                "covariance = sandwich + by_weights",
            ),
            (
                "spent += np.sum(share[is_belief] ** 2 / redundancy[is_belief], axis=0)",
                "spent += 0.0",
            ),
            ("if visible and value >= OPEN**-2:", "if visible and value >= 1e9 * OPEN**-2:"),
            (
                "return np.outer(moved, moved) + spread.T @ spread",
                "return spread.T @ spread",
            ),
        ],
    ),
    "evidence/predicted_strokes.py": (
        "tests/evidence/identification/test_stroke_block.py tests/evidence/identification",
        [
            ("for push in pushes]) / model.unit - travel", "for push in pushes]) / model.unit"),
            ("longer = normal / (normal @ toward)", "longer = normal"),
        ],
    ),
    "evidence/identification/stroke_block.py": (
        "tests/evidence/identification/test_stroke_block.py tests/evidence/identification",
        [
            ("predicted += weight * turns", "predicted += turns"),
            (
                "weight[:, np.newaxis] * (self.between @ by_unknowns)",
                "self.between @ by_unknowns",
            ),
            ("by_worn += worn * by_surface", "by_worn += 0.5 * by_surface"),
        ],
    ),
    "evidence/laws/measured_cycle_map.py": (
        "tests/evidence/laws",
        [
            (
                "reached = sign * (paths - start) >= TWO_PI - past",
                "reached = sign * (paths - start) >= TWO_PI",
            ),
            (
                "sign = np.where(seen & (np.abs(turn) > half), np.sign(turn), 0.0)",
                "sign = np.where(seen, np.sign(turn), 0.0)",
            ),
            (
                "bias = np.maximum(np.abs(around @ richer.coefficients), local)",
                "bias = local",
            ),
        ],
    ),
    "evidence/push_probe.py": (
        "tests/evidence/test_probe.py",
        [
            (
                "math.sqrt(2.0 * stats.f.ppf(CONFIDENCE, 2, free))",
                "math.sqrt(stats.f.ppf(CONFIDENCE, 2, free))",
            ),
            ("extra = 2 * order", "extra = order"),
            ("math.exp(2.0 * length)", "math.exp(length)"),
            ("free = moved.size - 7", "free = moved.size"),
        ],
    ),
    "evidence/simulated_collection.py": (
        "tests/evidence/simulation",
        [
            (
                "np.random.SeedSequence(self.seed, spawn_key=(stream, cycle))",
                "np.random.SeedSequence(self.seed, spawn_key=(stream, 0))",
            ),
            (
                "drawn[cycle] = rho * drawn[cycle - 1] + math.sqrt(1.0 - rho**2) * drawn[cycle]",
                "drawn[cycle] = rho * drawn[cycle - 1] + drawn[cycle]",
            ),
        ],
    ),
    "evidence/identified_material.py": (
        f"{IDENTIFICATION}/test_derived_quantities.py {IDENTIFICATION}",
        [
            ("(0.5 - identified.level / 2.0, 0.5 + identified.level / 2.0)", "(0.25, 0.75)"),
            (
                "off = rng.standard_normal(3) * identified.session_spread",
                "off = 0.0 * rng.standard_normal(3)",
            ),
            (
                "root = vectors * np.sqrt(np.maximum(squares, 0.0))",
                "root = vectors * np.maximum(squares, 0.0)",
            ),
        ],
    ),
    "evidence/motion_check.py": (
        f"{TABLES}/test_conventions.py",
        [
            ("_BEATEN = 0.5", "_BEATEN = 0.005"),
            (
                "(_EXPLAINS_TURNED if self.is_turned else _EXPLAINS) * other.length",
                "_EXPLAINS * other.length",
            ),
            ("share = 1.0 if looked.is_turned else _BEATEN", "share = 0.0"),
        ],
    ),
    "evidence/tables/columns.toml": (
        f"{PUSHES} {TABLES}",
        [
            ('"theta{end}_deg" = "deg"', '"theta{end}_deg" = ""'),
            ('tip_err_mm = "mm"', 'tip_err_mm = ""'),
        ],
    ),
    "evidence/tables/columns.py": (
        TABLES,
        [
            ('"compass": (-1.0, 0.5 * math.pi),', '"compass": (-1.0, 0.0),'),
            (
                "return sense * angle + (zero + self.offset)",
                "return sense * angle + (zero - self.offset)",
            ),
        ],
    ),
    "evidence/pushes/theta0_pairs.py": (
        f"{PUSHES}/test_theta0_pairs.py {PUSHES}",
        [
            ("return self.theta_next - self.theta", "return self.theta - self.theta_next"),
            ("turn = shorter_way(np.diff(theta))", "turn = np.mod(np.diff(theta), TWO_PI)"),
            ("off_next = (np.diff(cycle) == 1) & ", "off_next = "),
            ("return far if far.sum() <= _MOST_BY_HAND * turn.size else none", "return none"),
        ],
    ),
    "evidence/laws/turn_bins.py": (
        f"{PUSHES}/test_theta0_pairs.py {PUSHES}",
        [("np.where(high >= low, high, high + TWO_PI)", "high")],
    ),
    "evidence/pushes/push_files.py": (
        f"{PUSHES}/test_push_table.py {PUSHES}",
        [("across / along if along else math.nan", "along / across if along else math.nan")],
    ),
    "evidence/pushes/push_table.py": (
        f"{PUSHES}/test_push_table.py {PUSHES}",
        [
            ("number + 1.0), math.nan)", "number), math.nan)"),
            ("if length > _LONGEST_PUSH:", "if length > 1e9 * _LONGEST_PUSH:"),
            ("known_columns(table, ENDS, _MOST_LOST)", "known_columns(table, ENDS)"),
        ],
    ),
    "evidence/pushes/contact_forces.py": (
        f"{PUSHES} tests/evidence/identification",
        [
            (
                "np.median(np.abs(force.imag) / force.real)",
                "np.median(force.real / np.abs(force.imag))",
            ),
            ("(along - self.rod_radius * angle) / speed", "along / speed"),
            ("near & (force.real >= LEAST_PRESSING)", "near"),
        ],
    ),
    "evidence/tables/meaning.py": (
        TABLES,
        [
            ('"rad" if least <= _NO_RADIANS and', '"rad" if least > _NO_RADIANS and'),
            (
                "if {*_MIT_LETTERS.values()} <= {*by_name} else _MIT_UNITS",
                "if by_name else _MIT_UNITS",
            ),
        ],
    ),
    "evidence/tables/own_tables.py": (
        TABLES,
        [
            (
                'rows["repetition"] = _numbers_apart(repetition, rows)',
                'rows["repetition"] = repetition',
            ),
            ("np.diff(_collections(rows)) == 0.0", "np.diff(_collections(rows)) < 9.0"),
        ],
    ),
    "evidence/tables/text_tables.py": (
        TABLES,
        [('elif not len(with_comma) or is_any(",.*,"):', "elif True:")],
    ),
    "evidence/tables/pose_streams.py": (
        f"{TABLES}/test_pose_streams.py",
        [
            ("binary_propagation(change > high, mask=change > low)", "change > low"),
            ("s = sense * np.sin(poses[first, 2])", "s = np.sin(poses[first, 2])"),
            ("if home.mean() > _ALL_HOME:", "if home.mean() > 2.0:"),
        ],
    ),
    "evidence/pushes/measured_strokes.py": (
        f"{PUSHES}/test_measured_strokes.py {PUSHES}",
        [
            ('rows["tip_error"] > LARGEST_TIP_ERROR', 'rows["tip_error"] > 1e9'),
            (
                'ends = rows["theta0"] + shorter_way(rows["theta1"] - rows["theta0"])',
                'ends = rows["theta1"]',
            ),
        ],
    ),
    "resets/orientation_law.py": (
        DESIGN,
        [
            (
                "share = chance * (most - so_far[index]) / left",
                "share = chance / sum(1 for k, m in enumerate(counts) if so_far[k] < m)",
            ),
            ("np.exp(-0.5 * (orders * sigma) ** 2)", "np.exp(-(orders * sigma) ** 2)"),
            ("ended = steps[rest - 1] @ end if rest else end", "ended = end"),
            (
                "total_variation(ends, samples).max()])",
                "total_variation(ends, samples).min()])",
            ),
            (
                "np.max(np.abs(distances - before) + np.abs(distances - rough))",
                "np.max(np.abs(distances - rough))",
            ),
            ("done.append(kernel @ done[-1])", "done.append(done[-1] @ kernel)"),
        ],
    ),
    "resets/strategy_run.py": (
        "tests/resets/test_strategy_run.py tests/resets",
        [
            (
                "seeds += [np.random.SeedSequence(seed, spawn_key=(run,)) for run in range(1, "
                "runs)]",
                "seeds += [seed for run in range(1, runs)]",
            ),
            (
                "np.random.SeedSequence(seed, spawn_key=(_NOISE_STREAM,))",
                "np.random.SeedSequence(0, spawn_key=(1,))",
            ),
            ("+ turns[doing] + kicks[:, cycle]", "+ kicks[:, cycle]"),
            ("most = math.floor(count * chance) + 1", "most = math.floor(count * chance)"),
        ],
    ),
    "protocol/strategy.py": (
        "tests/resets/test_strategy.py tests/protocol",
        [
            ("blocks = [random.permutation(block) for", "blocks = [block for"),
            ("often.min() >= 0.5", "often.min() >= -1.0"),
        ],
    ),
    "resets/reset_design.py": (
        "tests/resets/test_reset_design.py tests/resets",
        [
            (
                "values[name] < limit if name == CONTACT else values[name] > limit",
                "values[name] > limit",
            ),
            (
                "own.worst_histogram[0] <= rows[0].worst_histogram[0]\n",
                "own.worst_histogram[0] > rows[0].worst_histogram[0]\n",
            ),
            ("where = self.about.worst(after)", "where = int(np.argmin(after))"),
        ],
    ),
    "resets/reset_ranking.py": (
        "tests/resets/test_reset_design.py tests/resets",
        [
            ("excess[CONTACT] = -excess[CONTACT]", "excess[CONTACT] = excess[CONTACT]"),
            ('kind="stable").index[0]', 'kind="stable").index[-1]'),
        ],
    ),
    "resets/material_range.py": (
        "tests/resets/test_material_range.py",
        [
            (
                'return first + int(np.argsort(values[first:], kind="stable")[rank - 1])',
                'return first + int(np.argsort(values[first:], kind="stable")[rank // 2])',
            ),
            ("n0=law.n0 * (1 + n0)", "n0=law.n0 * (1 + m0)"),
            ("mu_b=law.mu_b / root", "mu_b=law.mu_b"),
            (
                "tried = tuple(sample for place, sample in enumerate(samples) if place not in chosen)",
                "tried = tuple(samples)",
            ),
        ],
    ),
    "resets/action_cycles.py": (
        "tests/resets/test_action_cycles.py tests/resets",
        [
            ("travel / ROD_SPEED + HANDLING + GRIPPING * turned", "travel / ROD_SPEED + HANDLING"),
            ("lengths[push] = min(rough.model", "lengths[push] = max(rough.model"),
            ("[:, places] + gripped[:, None]", "[:, places]"),
        ],
    ),
    "resets/reset_search.py": (
        "tests/resets/test_reset_design.py tests/resets",
        [
            ("possible) >= least_contact", "possible) <= least_contact"),
            (
                "tv[rows] = np.maximum(\n                tv[rows],",
                "tv[rows] = np.minimum(\n                1.0 + tv[rows],",
            ),
        ],
    ),
    "resets/bias_evidence.py": (
        MONITOR,
        [
            ("settle(raised[:, 0] - log_mean)", "settle(raised[:, 0])"),
            (
                "self._shares = (1.0 / periods**2) / np.sum(1.0 / periods**2)",
                "self._shares = 1.0 / periods**2",
            ),
            (
                "np.log((_RATES if hit else 1.0 - _RATES) / CHANCE)",
                "np.log((_RATES if hit else 1.0) / CHANCE)",
            ),
            ("new = -math.log(self._bets * (self._bets + 1))", "new = 0.0"),
            ("pull = -(weights @ (off * (steps - y)))", "pull = (weights @ (off * (steps - y)))"),
            (
                "return float(likelihoods[0] / np.mean(likelihoods)) if",
                "return float(likelihoods[0]) if",
            ),
            ("paths[1:] = self._random.permuted(paths[1:], axis=1)", "paths[1:] = paths[1:]"),
            (
                "self._sum += self._e_value(turns, _MANY) / len(CHECKS)",
                "self._sum += self._e_value(turns, _MANY)",
            ),
            ("** visits.shape[1] * arcs", "** (visits.shape[1] - 1) * arcs"),
        ],
    ),
    "resets/bias_monitor.py": (
        MONITOR,
        [
            (
                "threshold = math.log(2.0 / self.alarm_rate)",
                "threshold = math.log(0.02 / self.alarm_rate)",
            ),
            (
                "self._arcs.log_evidence)) - math.log(\n            2.0\n        )",
                "self._arcs.log_evidence)) + math.log(\n            20.0\n        )",
            ),
        ],
    ),
    "resets/coverage.py": (
        "tests/resets/test_coverage.py tests/resets",
        [
            (
                "self._known += np.outer(self._last, self._last)",
                "self._known += self._last",
            ),
            ("widest = int(np.argmax(gaps))", "widest = int(np.argmin(gaps))"),
            ("best = int(np.argmin(crowding))", "best = int(np.argmax(crowding))"),
        ],
    ),
    "resets/audit.py": (
        "tests/resets/test_audit.py",
        [
            (
                "float(-reset_turn.mean() / mean)",
                "float(reset_turn.mean() / mean)",
            ),
            ("self.worth >= LEAST_WORTH * len(self.theta)", "self.worth >= 0.0 * len(self.theta)"),
        ],
    ),
    "protocol/schedule_file.py": (
        "tests/protocol/test_schedule_file.py",
        [
            ("> _AGREE_MM\n", "> 1e9 * _AGREE_MM\n"),
            ("math.degrees(math.atan2(dy, dx))", "math.degrees(math.atan2(dx, dy))"),
        ],
    ),
}
