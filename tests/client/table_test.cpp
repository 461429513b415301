#include "client/terminal/table.h"

#include <gtest/gtest.h>

namespace creepctl {
namespace {

Table jobs() {
  Table table({{"ID"}, {"STRAIN", Align::kRight}, {"NAME"}});
  table.add({"a1b2", "0.52 %", "loose"});
  table.add({"c3", "12 %", ""});
  return table;
}

TEST(Table, AlignsColumnsAndEndsNoLineWithASpace) {
  EXPECT_EQ(jobs().text(0),
            "ID    STRAIN  NAME\n"
            "a1b2  0.52 %  loose\n"
            "c3      12 %\n");
}

TEST(Table, CutsLinesAtTheWidthGiven) {
  EXPECT_EQ(jobs().text(9),
            "ID    STR\n"
            "a1b2  0.5\n"
            "c3      1\n");
}

TEST(Table, CountsCodePointsNotBytes) {
  Table table({{"A"}, {"B"}});
  table.add({"σ", "x"});
  table.add({"ab", "y"});
  EXPECT_EQ(table.text(0), "A   B\nσ   x\nab  y\n");
  EXPECT_EQ(table.text(1), "A\nσ\na\n");
}

TEST(Table, ALabelCannotMoveTheCursor) {
  Table table({{"A"}});
  table.add({"x\033[2Jy\nz"});
  EXPECT_EQ(table.text(0), "A\nx?[2Jy?z\n");
}

}  // namespace
}  // namespace creepctl
