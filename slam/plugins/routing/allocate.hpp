#pragma once

#include "slam/learner/lower_problem.hpp"
#include "slam/plugins/routing/allocation_network.hpp"

namespace imslam::routing {

/// z of allocation_network.hpp, (n - 1) x agents row by row. The instance needs coordinates.
learner::Vector allocation_logits(const AllocationNetwork<float>& network,
                                  const Instance& instance);

/// Each city to the agent with the largest logit; the first of equals. n - 1 numbers of agents.
learner::Vector likeliest_allocation(const learner::Vector& z, int agents);

}  // namespace imslam::routing
