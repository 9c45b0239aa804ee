#include "slam/plugins/routing/allocation_problem.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "slam/base/error.hpp"

namespace imslam::routing {

using learner::Matrix;
using learner::Vector;

Matrix allocation_probabilities(const Vector& z, int agents) {
  expects(agents > 0 && z.size() % agents == 0, "allocation: z must be cities x agents");
  Matrix p(z.size() / agents, agents);
  for (Eigen::Index i = 0; i < p.rows(); ++i) {
    const Vector row = z.segment(i * agents, agents);
    const Vector weights = (row.array() - row.maxCoeff()).exp();
    p.row(i) = (weights / weights.sum()).transpose();
  }
  return p;
}

std::vector<std::vector<int>> shares_of(const Instance& instance,
                                        const std::vector<int>& agent_of,
                                        int agents) {
  expects(static_cast<int>(agent_of.size()) == instance.city_count() - 1,
          "shares_of: one agent for each city but the depot");
  std::vector<std::vector<int>> shares(static_cast<std::size_t>(agents), {instance.depot});
  std::size_t next = 0;
  for (int city = 0; city < instance.city_count(); ++city) {
    if (city == instance.depot) continue;
    shares.at(static_cast<std::size_t>(agent_of[next++])).push_back(city);
  }
  return shares;
}

void AllocationProblem::set_instance(Instance instance) {
  instance_ = std::move(instance);
  symmetric_ = instance_.symmetric();
}

Vector AllocationProblem::draw(const Vector& z, Random& random) const {
  const Matrix p = allocation_probabilities(z, agents_);
  Vector x(p.rows());
  for (Eigen::Index i = 0; i < p.rows(); ++i) {
    double left = random.uniform();
    int agent = 0;
    while (agent + 1 < agents_ && left >= p(i, agent)) left -= p(i, agent++);
    x[i] = agent;
  }
  return x;
}

std::optional<double> AllocationProblem::cost(const Vector& x) const {
  std::vector<int> agent_of;
  for (const double agent : x) agent_of.push_back(static_cast<int>(agent));
  double longest = 0.0;
  for (const std::vector<int>& share : shares_of(instance_, agent_of, agents_)) {
    longest = std::max(longest, tour_length(instance_, solve_tour(instance_, symmetric_, share)));
  }
  return longest;
}

Vector AllocationProblem::score(const Vector& x, const Vector& z) const {
  Matrix score = -allocation_probabilities(z, agents_);
  for (Eigen::Index i = 0; i < x.size(); ++i) score(i, static_cast<Eigen::Index>(x[i])) += 1.0;
  const Matrix by_agent = score.transpose();
  return Eigen::Map<const Vector>(by_agent.data(), by_agent.size());
}

}  // namespace imslam::routing
