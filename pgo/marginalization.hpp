#pragma once

#include "pgo/graph_data.hpp"
#include "pgo/options.hpp"

namespace imslam::pgo {

/// What the first state and all factors that touch it say about the remaining unknowns.
///
/// The factors are linearised once, r(x) = r + A m + B k with m the first state and k its
/// neighbours and the globals, and m is eliminated by an orthogonal transformation (square-root
/// Schur complement): from Q^T [A | B r] the rows below the rank of A remain. Nothing is squared,
/// and directions of m that no factor observes cost no information about k.
///
/// First estimates: unknowns that an older prior already holds are linearised at that prior's
/// point, all others at their present value, and both keep that point in the new prior. So no
/// unknown is ever linearised at two points, which would make unobservable directions (position,
/// heading) look observed.
MarginalPrior marginalize_first_state(const GraphData& data, const GraphOptions& options);

/// Removes the first state and every factor that touches it, puts `prior` in their place and
/// renumbers the other states (state i becomes i - 1).
void drop_first_state(GraphData& data, MarginalPrior prior);

}  // namespace imslam::pgo
