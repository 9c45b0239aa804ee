#include "slam/plugins/routing/solution.hpp"

#include <gtest/gtest.h>

#include "slam/base/error.hpp"

namespace imslam::routing {
namespace {

Instance square() {
  Instance instance;
  instance.name = "square";
  instance.points = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
  return instance;
}

TEST(Solution, HasTheLengthsOfClosedTours) {
  const Solution solution = measured(square(), {{1, 2, 3}, {}});
  EXPECT_EQ(solution.lengths, (std::vector<double>{4.0, 0.0}));
  EXPECT_EQ(solution.longest(), 4.0);
  EXPECT_EQ(solution.total(), 4.0);
}

TEST(Solution, IsRefusedUnlessEachCityIsVisitedOnce) {
  EXPECT_THROW(measured(square(), {{1, 2}}), ContractError);
  EXPECT_THROW(measured(square(), {{1, 2, 3, 1}}), ContractError);
  EXPECT_THROW(measured(square(), {{0, 1, 2, 3}}), ContractError);
}

// What other programs read: the keys and their order are a promise.
TEST(Solution, JsonIsAsItAlwaysWas) {
  const Solution solution = measured(square(), {{1, 2}, {3}});
  const std::string golden =
      "{\"instance\":\"square\",\"cities\":4,\"depot\":0,\"agents\":2,"
      "\"longest\":3.414213562373095,\"total\":5.414213562373095,"
      "\"lengths\":[3.414213562373095,2.0],\"tours\":[[1,2],[3]]}\n";
  EXPECT_EQ(tours_json(square(), solution), golden);
  const Solution read = read_tours_json("golden", golden);
  EXPECT_EQ(read.tours, solution.tours);
  EXPECT_EQ(read.lengths, solution.lengths);
  EXPECT_THROW(read_tours_json("broken", golden.substr(0, 40)), InputError);
  EXPECT_THROW(read_tours_json("other", "{\"tours\":[[1]],\"lengths\":[]}"), InputError);
}

TEST(Solution, CsvGoesFromDepotToDepotAndThePictureHasEachTour) {
  const Solution solution = measured(square(), {{1, 2}, {3}, {}});
  const std::string csv = tours_csv(square(), solution);
  EXPECT_NE(csv.find("agent,stop,city,x,y,length\n0,0,0,0,0,0\n0,1,1,1,0,1\n"), std::string::npos);
  EXPECT_NE(csv.find("1,2,0,0,0,2\n2,0,0,0,0,0\n"), std::string::npos);
  const std::string svg = tours_svg(square(), solution);
  EXPECT_NE(svg.find("agent 1: 1 cities, length 2<"), std::string::npos);
  EXPECT_EQ(svg.find("agent 2"), std::string::npos);  // at home
}

}  // namespace
}  // namespace imslam::routing
