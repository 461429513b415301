#include "server/worker/snapshot_folder.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <string>
#include <vector>

#include "core/folder/durable_file.h"
#include "tests/server/file_size_limit.h"
#include "tests/server/temporary_directory.h"

namespace creepd {
namespace {

using creep::Snapshot;

/// As much of a picture as the folder looks at.
Snapshot picture(const std::string& name, double age, double dynamic_time, std::uint64_t next_sequence) {
  const auto number = [](const std::string& key, const std::string& value) {
    return "<DataArray type=\"Float64\" Name=\"" + key + "\" format=\"ascii\">" + value + "</DataArray>\n";
  };
  return {name,
          {.age = age, .dynamic_time = dynamic_time, .creep_time = age, .next_sequence = next_sequence},
          number("age_s", std::to_string(age)) + number("dynamic_time_s", std::to_string(dynamic_time)) +
              number("creep_time_s", std::to_string(age)) +
              number("next_sequence", std::to_string(next_sequence))};
}

std::vector<Snapshot> both(const std::string& label, double age, double dynamic_time,
                           std::uint64_t next_sequence) {
  return {picture("particles_" + label + ".vtp", age, dynamic_time, next_sequence),
          picture("contacts_" + label + ".vtp", age, dynamic_time, next_sequence)};
}

class SnapshotFolderTest : public testing::Test {
 protected:
  SnapshotFolder open() { return SnapshotFolder::open(path_).value(); }
  std::string text(const std::string& name) { return creep::read_file(path_ / name).value(); }

  TemporaryDirectory directory_;
  std::filesystem::path path_ = directory_.path() / "snapshots";
};

TEST_F(SnapshotFolderTest, IsNotMadeBeforeThereIsAPicture) {
  SnapshotFolder folder = open();
  ASSERT_TRUE(folder.write({}).ok());
  ASSERT_TRUE(folder.drop_after(0).ok());
  EXPECT_FALSE(std::filesystem::exists(path_));
  ASSERT_TRUE(folder.write(both("00_packing", 0.0, 0.0, 3)).ok());
  EXPECT_EQ(text("particles_00_packing.vtp"), picture("", 0.0, 0.0, 3).bytes);
}

TEST_F(SnapshotFolderTest, CollectionsHaveEveryPictureOnceInOrderWithItsTime) {
  SnapshotFolder first = open();
  ASSERT_TRUE(first.write(both("00_packing", 0.0, 0.0, 3)).ok());
  ASSERT_TRUE(first.write(both("01_oedometric", 0.0, 0.25, 9)).ok());
  SnapshotFolder second = open();
  ASSERT_TRUE(second.write(both("01_oedometric", 0.0, 0.25, 9)).ok()) << "a resumed run repeats it";
  ASSERT_TRUE(second.write(both("02_creep_0003", 1000.0, 0.5, 20)).ok());
  EXPECT_EQ(text("particles.pvd"),
            "<?xml version=\"1.0\"?>\n"
            "<VTKFile type=\"Collection\" version=\"0.1\" byte_order=\"LittleEndian\">\n"
            "<Collection>\n"
            "<DataSet timestep=\"0\" part=\"0\" file=\"particles_00_packing.vtp\"/>\n"
            "<DataSet timestep=\"0.25\" part=\"0\" file=\"particles_01_oedometric.vtp\"/>\n"
            "<DataSet timestep=\"1000.5\" part=\"0\" file=\"particles_02_creep_0003.vtp\"/>\n"
            "</Collection>\n</VTKFile>\n");
  EXPECT_NE(text("contacts.pvd").find("file=\"contacts_02_creep_0003.vtp\""), std::string::npos);
}

TEST_F(SnapshotFolderTest, PicturesOfOneTimeAreKeptApart) {
  SnapshotFolder folder = open();
  ASSERT_TRUE(folder.write(both("00_packing", 0.0, 0.0, 3)).ok());
  ASSERT_TRUE(folder.write(both("01_oedometric", 0.0, 0.0, 9)).ok());
  const std::string collection = text("particles.pvd");
  const std::size_t first = collection.find("timestep=\"0\"");
  ASSERT_NE(first, std::string::npos);
  EXPECT_EQ(collection.find("timestep=\"0\"", first + 1), std::string::npos) << collection;
}

TEST_F(SnapshotFolderTest, PicturesOfASupersededCourseGo) {
  ASSERT_TRUE(open().write(both("00_packing", 0.0, 0.0, 3)).ok());
  ASSERT_TRUE(open().write(both("02_creep_0003", 1000.0, 0.5, 20)).ok());
  ASSERT_TRUE(open().drop_after(15).ok());
  EXPECT_TRUE(std::filesystem::exists(path_ / "particles_00_packing.vtp"));
  EXPECT_FALSE(std::filesystem::exists(path_ / "particles_02_creep_0003.vtp"));
  EXPECT_EQ(text("contacts.pvd").find("creep"), std::string::npos);
}

TEST_F(SnapshotFolderTest, WhatAKilledWriterLeftIsRemovedAndStrangersAreLeftAlone) {
  ASSERT_TRUE(open().write(both("00_packing", 0.0, 0.0, 3)).ok());
  ASSERT_TRUE(creep::replace_file(path_ / "particles_01_oedometric.vtp.tmp", "half a pic").ok());
  ASSERT_TRUE(std::filesystem::create_directory(path_ / "mine"));
  ASSERT_TRUE(creep::replace_file(path_ / "particles_of_mine.vtp", "<VTKFile/>").ok());
  SnapshotFolder folder = open();
  EXPECT_FALSE(std::filesystem::exists(path_ / "particles_01_oedometric.vtp.tmp"));
  ASSERT_TRUE(folder.write(both("01_oedometric", 0.0, 0.25, 9)).ok());
  EXPECT_TRUE(std::filesystem::exists(path_ / "particles_of_mine.vtp"));
  EXPECT_EQ(text("particles.pvd").find("mine"), std::string::npos);
}

TEST_F(SnapshotFolderTest, AFullDiskIsToldAndLeavesNoHalfPicture) {
  SnapshotFolder folder = open();
  ASSERT_TRUE(folder.write(both("00_packing", 0.0, 0.0, 3)).ok());
  std::vector<Snapshot> large = both("01_oedometric", 0.0, 0.25, 9);
  large[0].bytes.append(100000, ' ');
  {
    const FileSizeLimit limit(50000);
    EXPECT_TRUE(absl::IsResourceExhausted(folder.write(large)));
  }
  EXPECT_FALSE(std::filesystem::exists(path_ / "particles_01_oedometric.vtp"));
  EXPECT_FALSE(std::filesystem::exists(path_ / "particles_01_oedometric.vtp.tmp"));
  ASSERT_TRUE(folder.write(large).ok());
  EXPECT_EQ(text("particles_01_oedometric.vtp"), large[0].bytes);
}

}  // namespace
}  // namespace creepd
