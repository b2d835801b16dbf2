"""Circle maps and everything asked of one: orbits, rotation, families, noise, passages, staircases.

Angles are radians, maps are lifts, rotation numbers are in turns a cycle. Knows no mechanics.

Maps
----
CircleMap : a map given by its lift; rigid, sine, Möbius, from samples
ParametricLift, ARNOLD_FAMILY, MOEBIUS_FAMILY : families by a formula
compose, conjugate, inverse, nth_iterate, shifted : maps made of maps
branches, Branch, preimages : where a lift is monotone; all θ with a given image
is_nondecreasing, lower_envelope, upper_envelope : folds, and the monotone lifts that bound a folded
    one
Estimate : a number and a bound on its error

Orbits
------
fixed_points, periodic_orbits, Orbit : each orbit once, with multiplier and kind
periodic_points, PeriodicPoints : all points of a period as arrays; proved=True makes number and
    bounds theorems
crossings_by_jump, JumpCrossing : where a jump passes the diagonal without a fixed point
basins, Basin : which θ tend to which stable orbit
slow_passages, SlowPassage : bottlenecks, as a saddle-node leaves them

Rotation
--------
rotation_number, RotationNumber : with bounds, and whether it is locked; proved=True makes both
    theorems
rotation_interval, RotationInterval : of a lift that folds
rotation_numbers, RotationNumbers, rotation_plane, RotationPlane : many at once
topological_entropy, kneading_sequences : of a lift that folds, with bounds from both sides
birkhoff_average : the mean of a function along an orbit, weighted to converge fast
lyapunov_exponent, lyapunov_exponents, LyapunovExponents : with noise by the operator; of many
    orbits

Families, p → CircleMap
-----------------------
follow_orbit, OrbitBranch, orbit_branches : periodic orbits continued in a parameter
bifurcations, Bifurcation, saddle_nodes, period_doublings, border_collisions : where orbits change
bifurcation_curves, BifurcationCurve, follow_bifurcation, CodimensionTwo : the same in a plane of
    two parameters
slow_folds, SlowFold : when a parameter that moves takes stable points away, and how late that shows
rest_multiplier, RestMultiplier : how much of an error the last cycles of a path keep, on its way to
    1
response, Response : derivatives of law, winding, stable points and passage times by the parameter,
    under noise
tongue, Tongue, tongues, TongueBoundaries : the parameters that lock to p/q
orbit_diagram, OrbitDiagram : where orbits are after a transient

Noise, added after the map
--------------------------
Noise, WrappedNormal, VonMises, WrappedCauchy, UniformNoise : the same everywhere
LocalNoise : kicks whose size depends on θ, for sampled paths
transfer_operator, TransferOperator : stationary density, moments, rotation, with error bounds
Spectrum : eigenvalues, with error bounds
MetastableSet : angles that a path rarely leaves, how often it is there

Passages
--------
mean_passage_time, log10_passage_time : cycles until an arc is left
hitting_probability, survival_probabilities : which arc first; staying for n cycles
quasi_stationary, QuasiStationary : where a path is that has not left an arc, and to which side it
    slips out

Staircases
----------
sample_staircase, sample_staircases, Staircase : noisy paths of the lifted orientation
predict_staircase, StaircaseSummary, SlowZone : where such a path rests, how long, how high it steps
find_steps, Steps : the dwells and steps of a path
compare_steps, StepComparison : found beside predicted
DriftingMap, predict_drift, DriftSummary : a map that changes with the cycle
"""

from typing import TYPE_CHECKING

from cyclemap.lazy_names import import_on_first_use

if TYPE_CHECKING:
    # What an editor and a type checker see; at run time each name is imported when it is first
    # used.
    from cyclemap.maps.estimate import Estimate as Estimate
    from cyclemap.maps.families.bifurcation_curves import (
        BifurcationCurve as BifurcationCurve,
        CodimensionTwo as CodimensionTwo,
        bifurcation_curves as bifurcation_curves,
        follow_bifurcation as follow_bifurcation,
    )
    from cyclemap.maps.families.bifurcations import (
        SlowFold as SlowFold,
        bifurcations as bifurcations,
        border_collisions as border_collisions,
        period_doublings as period_doublings,
        saddle_nodes as saddle_nodes,
        slow_folds as slow_folds,
    )
    from cyclemap.maps.families.continuation import (
        Bifurcation as Bifurcation,
        OrbitBranch as OrbitBranch,
        follow_orbit as follow_orbit,
        orbit_branches as orbit_branches,
    )
    from cyclemap.maps.families.family import (
        ARNOLD_FAMILY as ARNOLD_FAMILY,
        MOEBIUS_FAMILY as MOEBIUS_FAMILY,
        ParametricLift as ParametricLift,
    )
    from cyclemap.maps.families.long_orbits import (
        LyapunovExponents as LyapunovExponents,
        OrbitDiagram as OrbitDiagram,
        RestMultiplier as RestMultiplier,
        lyapunov_exponents as lyapunov_exponents,
        orbit_diagram as orbit_diagram,
        rest_multiplier as rest_multiplier,
    )
    from cyclemap.maps.families.response import Response as Response, response as response
    from cyclemap.maps.families.rotation_numbers import (
        RotationNumbers as RotationNumbers,
        RotationPlane as RotationPlane,
        rotation_numbers as rotation_numbers,
        rotation_plane as rotation_plane,
    )
    from cyclemap.maps.families.tongues import (
        Tongue as Tongue,
        TongueBoundaries as TongueBoundaries,
        tongue as tongue,
        tongues as tongues,
    )
    from cyclemap.maps.lifts.branches import (
        Branch as Branch,
        branches as branches,
        preimages as preimages,
    )
    from cyclemap.maps.lifts.circle_map import CircleMap as CircleMap
    from cyclemap.maps.lifts.map_algebra import (
        compose as compose,
        conjugate as conjugate,
        inverse as inverse,
        nth_iterate as nth_iterate,
        shifted as shifted,
    )
    from cyclemap.maps.noise import (
        Noise as Noise,
        UniformNoise as UniformNoise,
        VonMises as VonMises,
        WrappedCauchy as WrappedCauchy,
        WrappedNormal as WrappedNormal,
    )
    from cyclemap.maps.operator.spectrum import (
        MetastableSet as MetastableSet,
        Spectrum as Spectrum,
    )
    from cyclemap.maps.operator.transfer_operator import (
        TransferOperator as TransferOperator,
        transfer_operator as transfer_operator,
    )
    from cyclemap.maps.orbits.basins import Basin as Basin, basins as basins
    from cyclemap.maps.orbits.diagonal import (
        JumpCrossing as JumpCrossing,
        SlowPassage as SlowPassage,
        slow_passages as slow_passages,
    )
    from cyclemap.maps.orbits.entropy import (
        kneading_sequences as kneading_sequences,
        topological_entropy as topological_entropy,
    )
    from cyclemap.maps.orbits.orbit_means import (
        birkhoff_average as birkhoff_average,
        lyapunov_exponent as lyapunov_exponent,
    )
    from cyclemap.maps.orbits.periodic_points import (
        Orbit as Orbit,
        PeriodicPoints as PeriodicPoints,
        crossings_by_jump as crossings_by_jump,
        fixed_points as fixed_points,
        periodic_orbits as periodic_orbits,
        periodic_points as periodic_points,
    )
    from cyclemap.maps.orbits.rotation_number import (
        RotationInterval as RotationInterval,
        RotationNumber as RotationNumber,
        is_nondecreasing as is_nondecreasing,
        lower_envelope as lower_envelope,
        rotation_interval as rotation_interval,
        rotation_number as rotation_number,
        upper_envelope as upper_envelope,
    )
    from cyclemap.maps.passages.killed_chain import (
        QuasiStationary as QuasiStationary,
        quasi_stationary as quasi_stationary,
    )
    from cyclemap.maps.passages.log_passage import log10_passage_time as log10_passage_time
    from cyclemap.maps.passages.passage_times import (
        hitting_probability as hitting_probability,
        mean_passage_time as mean_passage_time,
        survival_probabilities as survival_probabilities,
    )
    from cyclemap.maps.staircases.drifting_map import (
        DriftingMap as DriftingMap,
        DriftSummary as DriftSummary,
        predict_drift as predict_drift,
    )
    from cyclemap.maps.staircases.slow_zones import (
        SlowZone as SlowZone,
        StaircaseSummary as StaircaseSummary,
        predict_staircase as predict_staircase,
    )
    from cyclemap.maps.staircases.staircase import (
        LocalNoise as LocalNoise,
        Staircase as Staircase,
        sample_staircase as sample_staircase,
        sample_staircases as sample_staircases,
    )
    from cyclemap.maps.staircases.steps import (
        StepComparison as StepComparison,
        Steps as Steps,
        compare_steps as compare_steps,
        find_steps as find_steps,
    )
else:
    import_on_first_use(__name__)
