#include "slam/base/config.hpp"

#include <gtest/gtest.h>

#include <cstdlib>

#include "slam/base/error.hpp"
#include "tests/support/temp_dir.hpp"

namespace imslam {
namespace {

struct InnerOptions {
  double width = 0.5;
  std::string kernel = "huber";
  void describe(Config& config) {
    config.field("width", width, "width of the kernel");
    config.field("kernel", kernel, {"huber", "cauchy"}, "robust kernel");
  }
};

struct Options {
  bool verbose = false;
  int rounds = 7;
  std::string title = "a title: with # signs";
  InnerOptions inner;
  void describe(Config& config) {
    config.field("verbose", verbose, "says more");
    config.field("rounds", rounds, "how often");
    config.field("title", title, "free text");
    config.section("inner", inner);
  }
};

class ConfigTest : public ::testing::Test {
 protected:
  ConfigTest() { config_.section("pgo", options_); }

  /// The message of the InputError that `action` throws.
  template <typename Action>
  std::string message_of(const Action& action) {
    try {
      action();
    } catch (const InputError& error) {
      EXPECT_EQ(error.code(), ExitCode::kUsage);
      return error.what();
    }
    ADD_FAILURE() << "expected InputError";
    return "";
  }
  std::string message_of_file(const std::string& content) {
    return message_of([&] { config_.load_file(folder_.write("test.yaml", content)); });
  }
  static bool contains(const std::string& text, const std::string& part) {
    return text.find(part) != std::string::npos;
  }

  testing::TempDir folder_;
  Options options_;
  Config config_;
};

TEST_F(ConfigTest, DefaultsStayWhereNothingIsSaid) {
  config_.load_file(folder_.write("empty.yaml", ""));
  config_.load_environment();
  EXPECT_EQ(options_.rounds, 7);
  EXPECT_EQ(config_.changes(), "");
}

TEST_F(ConfigTest, FileYieldsToEnvironmentAndEnvironmentToCommandLine) {
  config_.load_file(
      folder_.write("a.yaml", "pgo:\n  rounds: 1\n  verbose: yes\n  inner: {width: 2.5}\n"));
  EXPECT_EQ(options_.rounds, 1);
  EXPECT_TRUE(options_.verbose);
  EXPECT_EQ(options_.inner.width, 2.5);
  ::setenv("IMSLAM_PGO_ROUNDS", "2", 1);
  ::setenv("IMSLAM_PGO_INNER_WIDTH", "3.5", 1);
  config_.load_environment();
  ::unsetenv("IMSLAM_PGO_ROUNDS");
  ::unsetenv("IMSLAM_PGO_INNER_WIDTH");
  EXPECT_EQ(options_.rounds, 2);
  EXPECT_EQ(options_.inner.width, 3.5);
  config_.set("pgo.rounds = 3", "--set");
  EXPECT_EQ(options_.rounds, 3);
}

TEST_F(ConfigTest, AnUnknownKeyInTheEnvironmentIsAnErrorIfItNamesASection) {
  ::setenv("IMSLAM_PGO_ROUNDZ", "2", 1);
  const std::string message = message_of([&] { config_.load_environment(); });
  ::unsetenv("IMSLAM_PGO_ROUNDZ");
  EXPECT_TRUE(contains(message, "IMSLAM_PGO_ROUNDZ")) << message;
  EXPECT_TRUE(contains(message, "did you mean 'IMSLAM_PGO_ROUNDS'")) << message;
  ::setenv("IMSLAM_OTHER_ROUNDS", "2", 1);
  EXPECT_NO_THROW(config_.load_environment());
  ::unsetenv("IMSLAM_OTHER_ROUNDS");
}

TEST_F(ConfigTest, UnknownKeysPointToTheCommandThatListsThem) {
  config_.listed_by("imslam simulate --list");
  const std::string message = message_of([&] { config_.set("pgo.x=1", "--set"); });
  EXPECT_TRUE(contains(message, "`imslam simulate --list` lists all keys")) << message;
}

TEST_F(ConfigTest, UnknownKeyNamesFileLineAndTheNearestKey) {
  const std::string message = message_of_file("pgo:\n  verbose: true\n  roundz: 3\n");
  EXPECT_TRUE(contains(message, "test.yaml:3")) << message;
  EXPECT_TRUE(contains(message, "pgo.roundz")) << message;
  EXPECT_TRUE(contains(message, "did you mean 'pgo.rounds'")) << message;
}

TEST_F(ConfigTest, WrongTypesNameTheLineTheKeyAndTheValue) {
  for (const std::string line :
       {"rounds: 2.5", "rounds: many", "rounds: 99999999999", "verbose: perhaps",
        "inner: {width: nan}", "inner: {width: 1,5}", "inner: {kernel: tukey}", "rounds: [1, 2]"}) {
    const std::string message = message_of_file("pgo:\n  " + line + "\n");
    EXPECT_TRUE(contains(message, "test.yaml:2")) << message;
    EXPECT_TRUE(contains(message, "pgo.")) << message;
  }
  EXPECT_TRUE(contains(message_of_file("pgo: {inner: {kernel: tukey}}"), "huber, cauchy"));
}

TEST_F(ConfigTest, SyntaxErrorsNameTheLine) {
  EXPECT_TRUE(contains(message_of_file("pgo:\n  rounds: 1\n bad: [\n"), "test.yaml:"));
  EXPECT_TRUE(contains(message_of_file("just a word"), "test.yaml:1"));
  EXPECT_TRUE(contains(message_of_file("{{{{"), "test.yaml:1"));
  EXPECT_TRUE(contains(message_of_file("? [a, b]\n: c\n"), "test.yaml:1"));
}

TEST_F(ConfigTest, DeepNestingIsRefusedNotRecursedInto) {
  std::string deep;
  for (int i = 0; i < 20; ++i) deep += std::string(static_cast<std::size_t>(i), ' ') + "a:\n";
  EXPECT_TRUE(contains(message_of_file(deep + std::string(20, ' ') + "b: 1\n"), "test.yaml"));
}

TEST_F(ConfigTest, AMissingFileIsAUsageError) {
  EXPECT_TRUE(
      contains(message_of([&] { config_.load_file(folder_.path() / "no.yaml"); }), "no.yaml"));
}

TEST_F(ConfigTest, BrokenAssignmentsNameTheirOrigin) {
  EXPECT_TRUE(contains(message_of([&] { config_.set("pgo.rounds", "--set"); }), "--set"));
  EXPECT_TRUE(contains(message_of([&] { config_.set("pgo.rounds=x", "--set"); }), "--set"));
}

TEST_F(ConfigTest, YamlReadsBackToTheSameValues) {
  options_.title = "quotes \" and \\ backslash\nnew line";
  options_.inner.width = 0.1;
  options_.inner.kernel = "cauchy";
  for (const bool with_help : {false, true}) {
    Options copy;
    Config other;
    other.section("pgo", copy);
    other.load_file(folder_.write("dump.yaml", config_.to_yaml(with_help)));
    EXPECT_EQ(copy.title, options_.title);
    EXPECT_EQ(copy.inner.width, 0.1);
    EXPECT_EQ(copy.inner.kernel, "cauchy");
    EXPECT_EQ(other.to_yaml(), config_.to_yaml());
  }
}

TEST_F(ConfigTest, TextThatLooksLikeAnotherTypeReadsBack) {
  for (const std::string text : {"", "null", "~", "true", "1.0", "-", "- a", "a: b", " padded "}) {
    options_.title = text;
    Options copy;
    Config other;
    other.section("pgo", copy);
    other.load_file(folder_.write("dump.yaml", config_.to_yaml()));
    EXPECT_EQ(copy.title, text);
  }
}

TEST_F(ConfigTest, ChangesListWhatDiffersFromTheDefaults) {
  config_.set("pgo.inner.width=0.25", "--set");
  EXPECT_EQ(config_.changes(), "pgo.inner.width=0.25\n");
}

TEST_F(ConfigTest, BindingAKeyTwiceIsABug) {
  EXPECT_THROW(config_.section("pgo", options_), ContractError);
}

}  // namespace
}  // namespace imslam
