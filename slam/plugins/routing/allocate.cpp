#include "slam/plugins/routing/allocate.hpp"

#include "slam/base/error.hpp"
#include "slam/learner/imperative_loss.hpp"

namespace imslam::routing {

learner::Vector allocation_logits(const AllocationNetwork<float>& network,
                                  const Instance& instance) {
  expects(!instance.points.empty(), "allocation_logits: the instance has no coordinates");
  nn::Tape<float> tape(nn::Mode::kInference);
  const nn::Var features = tape.constant(city_features(instance));
  return learner::numbers_of(tape, network.forward(tape, features));
}

learner::Vector likeliest_allocation(const learner::Vector& z, int agents) {
  learner::Vector x(z.size() / agents);
  for (Eigen::Index i = 0; i < x.size(); ++i) {
    Eigen::Index agent = 0;
    z.segment(i * agents, agents).maxCoeff(&agent);
    x[i] = static_cast<double>(agent);
  }
  return x;
}

}  // namespace imslam::routing
