#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "pipeline/report/csv.h"
#include "tests/pipeline/cache_support.h"

namespace wry::pipeline {

using namespace testing;

namespace {

const std::vector<std::string> COLUMNS = {"frame", "step", "dt [s], last"};

CsvWriter open(const TemporaryFolder& folder, std::int64_t last_kept) {
  Result<CsvWriter> csv = CsvWriter::open(folder.path() / "stats.csv", COLUMNS, "frame", last_kept);
  EXPECT_TRUE(csv.ok()) << csv.error().message;
  return *std::move(csv);
}

void append(CsvWriter& csv, std::vector<double> row) {
  const Status appended = csv.append(row);
  EXPECT_TRUE(appended.ok()) << appended.error().message;
}

std::string text(const TemporaryFolder& folder) {
  return contents(folder.path() / "stats.csv");
}

} // namespace

TEST(CsvWriter, WritesAHeaderAndWholeRows) {
  TemporaryFolder folder;
  CsvWriter csv = open(folder, 0);
  append(csv, {1, 2, 0.01});
  append(csv, {1, 3, 1e-300});
  ASSERT_TRUE(csv.sync().ok());
  EXPECT_EQ(text(folder), "frame,step,\"dt [s], last\"\n1,2,0.01\n1,3,1e-300\n");
  EXPECT_FALSE(csv.append(std::vector<double>{1, 2}).ok());
}

TEST(CsvWriter, CutsOffRowsAfterThePointOfResuming) {
  TemporaryFolder folder;
  {
    CsvWriter csv = open(folder, 0);
    for (int frame = 1; frame <= 5; ++frame) {
      append(csv, {double(frame), 2.0 * frame, 0.5});
      append(csv, {double(frame), 2.0 * frame + 1, 0.25});
    }
  }
  CsvWriter csv = open(folder, 3);
  EXPECT_EQ(csv.kept_rows(), 6u);
  append(csv, {4, 8, 0.5});
  EXPECT_EQ(text(folder),
            "frame,step,\"dt [s], last\"\n1,2,0.5\n1,3,0.25\n2,4,0.5\n2,5,0.25\n3,6,0.5\n3,7,0.25\n4,8,0.5\n");
}

TEST(CsvWriter, SurvivesATearAtEveryByte) {
  TemporaryFolder folder;
  {
    CsvWriter csv = open(folder, 0);
    for (int frame = 1; frame <= 4; ++frame)
      append(csv, {double(frame), 10.0 + frame, 0.125});
  }
  const std::string whole = text(folder);
  for (std::size_t size = 0; size <= whole.size(); ++size) {
    spoil(folder.path() / "stats.csv", whole.substr(0, size));
    const std::size_t kept = open(folder, 100).kept_rows();
    const std::size_t lines =
        static_cast<std::size_t>(std::count(whole.begin(), whole.begin() + static_cast<long>(size), '\n'));
    EXPECT_EQ(kept, lines == 0 ? 0 : lines - 1) << size;
    EXPECT_EQ(text(folder).back(), '\n');
  }
}

TEST(CsvWriter, ReplacesATableOfOtherColumns) {
  TemporaryFolder folder;
  spoil(folder.path() / "stats.csv", "frame,other\n1,2\n");
  EXPECT_EQ(open(folder, 100).kept_rows(), 0u);
  EXPECT_EQ(text(folder), "frame,step,\"dt [s], last\"\n");
  EXPECT_EQ(CsvWriter::open(folder.path() / "x.csv", COLUMNS, "nothing", 0).error().code, ErrorCode::usage);
}

TEST(CsvWriter, NumbersReadBackBitForBit) {
  TemporaryFolder folder;
  const double odd = std::bit_cast<double>(0x3fd5555555555555ull);
  {
    CsvWriter csv = open(folder, 0);
    append(csv, {1, odd, std::numeric_limits<double>::infinity()});
    append(csv, {1, -0.0, std::numeric_limits<double>::denorm_min()});
  }
  const std::string table = text(folder);
  const std::size_t start = table.find('\n') + 1;
  const std::vector<std::string> row = split_csv_line(table.substr(start, table.find('\n', start) - start));
  EXPECT_EQ(std::strtod(row[1].c_str(), nullptr), odd);
  EXPECT_EQ(row[2], "inf");
  EXPECT_NE(table.find("1,-0,5e-324\n"), std::string::npos) << table;
}

TEST(CsvFields, AreQuotedAndReadBack) {
  const std::vector<std::string> fields = {"plain", "with, comma", "with \"quotes\"", ""};
  std::string line;
  for (const std::string& field : fields)
    line += fmt::format("{}{}", &field == &fields.front() ? "" : ",", csv_field(field));
  EXPECT_EQ(split_csv_line(line), fields);
}

} // namespace wry::pipeline
