#include "slam/plugins/routing/read_instance.hpp"

#include <gtest/gtest.h>

#include "slam/base/error.hpp"

namespace imslam::routing {
namespace {

std::string message_of(const std::string& text, int depot = 0) {
  try {
    parse_instance("cities", text, depot);
  } catch (const InputError& error) {
    return error.what();
  }
  return "no error";
}

std::string tsplib(const std::string& type, const std::string& rest) {
  return "NAME : few\nTYPE : TSP\nCOMMENT : three cities\nDIMENSION : 3\nEDGE_WEIGHT_TYPE : " +
         type + "\n" + rest + "EOF\n";
}

TEST(ReadInstance, TsplibRoundsAsEachTypeSays) {
  const std::string points = "NODE_COORD_SECTION\n1 0 0\n2 1.0e0 1\n3 10 0\n";
  const Instance rounded = parse_instance("f", tsplib("EUC_2D", points), 0);
  EXPECT_EQ(rounded.name, "few");
  EXPECT_EQ(rounded.city_count(), 3);
  EXPECT_EQ(rounded.distance(0, 1), 1.0);  // 1.414
  EXPECT_EQ(parse_instance("f", tsplib("CEIL_2D", points), 0).distance(0, 1), 2.0);
  EXPECT_EQ(parse_instance("f", tsplib("ATT", points), 0).distance(0, 2), 4.0);  // 3.162 up
  EXPECT_EQ(parse_instance("f", tsplib("ATT", points), 0).distance(0, 1), 1.0);  // 0.447 up
}

// Along a meridian 1 degree is R pi / 180 = 111.32 km, and a whole number is added and cut off; 30
// minutes are written .30.
TEST(ReadInstance, TsplibGeographicIsDegreesAndMinutesOnABall) {
  const std::string points = "NODE_COORD_SECTION\n1 10 0\n2 11 0\n3 10.30 0\n";
  const Instance instance = parse_instance("f", tsplib("GEO", points), 0);
  EXPECT_EQ(instance.distance(0, 1), 112.0);
  EXPECT_EQ(instance.distance(0, 2), 56.0);
}

TEST(ReadInstance, TsplibTablesInEveryFormatAreTheSameTable) {
  const auto with = [](const std::string& format, const std::string& numbers) {
    return parse_instance(
        "f",
        tsplib("EXPLICIT", "EDGE_WEIGHT_FORMAT : " + format + "\nEDGE_WEIGHT_SECTION\n" + numbers),
        1);
  };
  for (const auto& [format, numbers] :
       {std::pair<std::string, std::string>{"FULL_MATRIX", "0 1 2\n1 0 3 2 3\n0\n"},
        {"UPPER_ROW", "1 2\n3\n"},
        {"LOWER_ROW", "1\n2 3\n"},
        {"UPPER_DIAG_ROW", "0 1 2\n0 3 0\n"},
        {"LOWER_DIAG_ROW", "0\n1 0\n2 3 0\n"}}) {
    const Instance instance = with(format, numbers);
    EXPECT_EQ(instance.matrix, (std::vector<double>{0, 1, 2, 1, 0, 3, 2, 3, 0})) << format;
    EXPECT_TRUE(instance.symmetric());
    EXPECT_EQ(instance.depot, 1);
  }
}

TEST(ReadInstance, TablesAreCoordinatesOrDistancesByTheirShape) {
  const Instance plane = parse_instance("f.csv", "x,y\n# comment\n0,0\n3,4\r\n\n1.5,2\n", 2);
  EXPECT_EQ(plane.city_count(), 3);
  EXPECT_EQ(plane.distance(0, 1), 5.0);
  EXPECT_EQ(plane.depot, 2);
  EXPECT_EQ(plane.name, "f");
  const Instance table = parse_instance("f", "0 5 1\n2;0;9\n3,4,0\n", 0);
  EXPECT_EQ(table.metric, Metric::kMatrix);
  EXPECT_EQ(table.distance(0, 1), 5.0);
  EXPECT_EQ(table.distance(1, 0), 2.0);
  EXPECT_FALSE(table.symmetric());
}

TEST(ReadInstance, ErrorsNameTheLineAndWhatWasExpected) {
  EXPECT_NE(message_of("0,0\n1,nan\n").find("cities:2: a number is not finite"), std::string::npos);
  EXPECT_NE(message_of("0,0\n1,1\n2\n").find("cities:3: expected x,y"), std::string::npos);
  EXPECT_NE(message_of("0,0\n1,a\n").find("cities:2: expected numbers"), std::string::npos);
  EXPECT_NE(message_of("0 1 2\n1 0\n2 3 0\n").find("cities:2: a table"), std::string::npos);
  EXPECT_NE(message_of("0 1 -2\n1 0 2\n2 3 0\n").find("cities:1: a distance is neg"),
            std::string::npos);
  EXPECT_NE(message_of("0,0\n").find("expected 2 or more"), std::string::npos);
  EXPECT_NE(message_of("").find("expected 2 or more"), std::string::npos);
  EXPECT_NE(message_of("0,0\n1,1\n", 2).find("no city 2 to be the depot"), std::string::npos);
  EXPECT_NE(message_of("0,0\n1,1\n", -1).find("--depot 0 to 1"), std::string::npos);
}

TEST(ReadInstance, TsplibErrorsNameTheLineAndTheKey) {
  const std::string points = "NODE_COORD_SECTION\n1 0 0\n2 1 1\n3 5 0\n";
  EXPECT_NE(message_of(tsplib("MAN_2D", points)).find("cities:5: EDGE_WEIGHT_TYPE: expected"),
            std::string::npos);
  EXPECT_NE(message_of(tsplib("EUC_2D", "NODE_COORD_SECTION\n1 0 0\n2 1\n")).find("cities:8:"),
            std::string::npos);
  EXPECT_NE(message_of(tsplib("EUC_2D", "NODE_COORD_SECTION\n1 0 0\n1 1 1\n3 0 0\n"))
                .find("expected each of 1 to 3 once"),
            std::string::npos);
  EXPECT_NE(message_of(tsplib("EUC_2D", "")).find("NODE_COORD_SECTION is missing"),
            std::string::npos);
  EXPECT_NE(message_of("DIMENSION : -4\n").find("cities:1: DIMENSION"), std::string::npos);
  EXPECT_NE(message_of("TYPE : CVRP\nDIMENSION : 3\n").find("TYPE: expected"), std::string::npos);
  EXPECT_NE(
      message_of(tsplib("EXPLICIT", "EDGE_WEIGHT_FORMAT : UPPER_ROW\nEDGE_WEIGHT_SECTION\n1 2\n"))
          .find("EDGE_WEIGHT_SECTION"),
      std::string::npos);
  EXPECT_NE(message_of(tsplib("EXPLICIT", "EDGE_WEIGHT_SECTION\n1 2 3\n"))
                .find("EDGE_WEIGHT_FORMAT: expected"),
            std::string::npos);
}

TEST(ReadInstance, NumbersThatSwallowAllOthersAreRefused) {
  for (const char* text : {"0 1 1e30\n1 0 1\n1e30 1 0\n", "0,0\n1e39,1\n", "0,0\n1,-1e39\n"}) {
    try {
      parse_instance("cities", text, 0);
      ADD_FAILURE() << "expected InputError of " << text;
    } catch (const InputError& error) {
      EXPECT_EQ(error.code(), ExitCode::kData);
    }
  }
  EXPECT_NE(message_of("0 1 1e30\n1 0 1\n1e30 1 0\n").find("a distance of 1e+30"),
            std::string::npos);
  EXPECT_NE(message_of("0,0\n1,-1e39\n").find("a coordinate of 1e+39"), std::string::npos);
  EXPECT_EQ(message_of("0 1 1e6\n1 0 1\n1e6 1 0\n"), "no error");
  EXPECT_EQ(message_of("0 0 0\n0 0 0\n0 0 0\n"), "no error");
}

// Cut anywhere, a file is an error or an instance, never a crash.
TEST(ReadInstance, AnyBeginningOfAFileIsReadOrRefused) {
  const std::string whole = tsplib("EUC_2D", "NODE_COORD_SECTION\n1 0 0\n2 1 1\n3 5 0\n");
  for (std::size_t length = 0; length < whole.size(); ++length) {
    const std::string message = message_of(whole.substr(0, length));
    EXPECT_FALSE(message.empty());
  }
}

}  // namespace
}  // namespace imslam::routing
