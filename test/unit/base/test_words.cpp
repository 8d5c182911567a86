// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <array>

#include "voxnav/base/config.hpp"

namespace {

using namespace voxnav;  // NOLINT: test

enum class Colour : std::uint8_t { kRed, kGreen, kBlue };
constexpr auto words_of(Colour) { return std::array{"red", "green", "deep-blue"}; }
enum class Wordless { kOne };

class Outer {
 public:
  enum class Inner { kIn, kOut };
  friend constexpr auto words_of(Inner) { return std::array{"in", "out"}; }
};

static_assert(base::HasWords<Colour>::value);
static_assert(base::HasWords<Outer::Inner>::value);
static_assert(!base::HasWords<Wordless>::value);
static_assert(!base::HasWords<int>::value);
static_assert(!base::HasWords<std::string>::value);

TEST(Words, EveryValueHasItsWordAndEveryWordItsValue) {
  EXPECT_EQ(base::all_words<Colour>(), (std::vector<std::string>{"red", "green", "deep-blue"}));
  EXPECT_EQ(base::all_values<Colour>(), (std::vector<Colour>{Colour::kRed, Colour::kGreen, Colour::kBlue}));
  for (const Colour colour : base::all_values<Colour>()) {
    EXPECT_EQ(base::value_of_word<Colour>(base::word_of(colour)), colour);
  }
  EXPECT_STREQ(base::word_of(Outer::Inner::kOut), "out");
}

TEST(Words, UnknownWordsAndNumbersAreNothing) {
  EXPECT_FALSE(base::value_of_word<Colour>("Red"));
  EXPECT_FALSE(base::value_of_word<Colour>(""));
  EXPECT_STREQ(base::word_of(static_cast<Colour>(3)), "(none)");
  EXPECT_FALSE(base::value_of_word<Colour>("(none)"));
}

struct Painted {
  Colour colour = Colour::kGreen;

  template <class V>
  static void fields(V&& v) {
    v("colour", &Painted::colour, base::one_of<Colour>(), "", "of the paint");
  }
};

TEST(Words, ConfigurationsReadAndWriteWords) {
  const auto fields = base::describe(Painted{});
  ASSERT_EQ(fields.size(), 1u);
  EXPECT_EQ(std::get<std::string>(fields[0].value), "green");
  EXPECT_EQ(fields[0].rule.choices, base::all_words<Colour>());
  Painted painted;
  EXPECT_TRUE(base::assign(&painted, {{"colour", std::string("deep-blue")}}).empty());
  EXPECT_EQ(painted.colour, Colour::kBlue);
}

TEST(Words, AWordThatDoesNotExistIsRefusedAndLeavesTheFieldAsItWas) {
  Painted painted;
  EXPECT_EQ(base::assign(&painted, {{"colour", std::string("blue")}}),
            std::vector<std::string>{"colour = 'blue': allowed is one of red, green, deep-blue"});
  EXPECT_EQ(painted.colour, Colour::kGreen);
}

TEST(Words, ANumberThatIsNoEnumeratorIsRefused) {
  Painted painted;
  painted.colour = static_cast<Colour>(9);
  EXPECT_THROW(base::checked(painted), base::ConfigError);
}

}  // namespace
