#include "studio/folder.hpp"

#include "scratch.hpp"

#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include "batten/core/error.hpp"

namespace batten::studio {
namespace {

namespace fs = std::filesystem;
using Outcome = Written::Outcome;

class Folders : public testing::Test {
 protected:
  void SetUp() override {
    root = fs::path(test::scratch()) / "folders";
    fs::remove_all(root);
    put("work/hull.ply", "hull");
    put("work/deep/net.json", "net");
    put("outside/secret.ply", "secret");
  }
  void put(const std::string& path, const std::string& content) const {
    fs::create_directories((root / path).parent_path());
    std::ofstream(root / path) << content;
  }
  std::string get(const std::string& path) const {
    std::ifstream in(root / path);
    return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
  }
  static std::vector<std::string> names(const Listing& listing) {
    std::vector<std::string> all;
    for (const ListedFile& file : listing.files) all.push_back(file.name);
    return all;
  }
  static std::string content(const OpenedBytes& opened) {
    std::string bytes(opened.size, '\0');
    EXPECT_EQ(::read(opened.descriptor.number(), bytes.data(), bytes.size()),
              static_cast<ssize_t>(bytes.size()));
    return bytes;
  }
  std::string work() const { return (root / "work").string(); }

  fs::path root;
};

TEST_F(Folders, ListWhatTheStudioReads) {
  put("work/.hidden.ply", "");
  put("work/.git/x.json", "");
  put("work/notes.md", "");
  put("work/id_rsa", "");
  put("work/big.obj.gz", "12345");
  mkfifo((root / "work/pipe.ply").c_str(), 0600);
  fs::create_directory(root / "work/folder.ply");
  Folder folder(work());
  const Listing listing = folder.list();
  EXPECT_EQ(names(listing), (std::vector<std::string>{"big.obj.gz", "deep/net.json", "hull.ply"}));
  EXPECT_EQ(listing.files[0].size, 5U);
  EXPECT_EQ(content(folder.open(listing.files[1].number)), "net");
  EXPECT_FALSE(folder.first().has_value());
}

TEST_F(Folders, NumbersStayWithTheirFiles) {
  Folder folder(work());
  const int hull = folder.list().files[1].number;
  put("work/a.ply", "a");
  EXPECT_EQ(folder.list().files.size(), 3U);
  EXPECT_EQ(content(folder.open(hull)), "hull");
  fs::remove(root / "work/hull.ply");
  EXPECT_FALSE(folder.open(hull).descriptor.is_open());
  for (const long number : {-1L, 3L, 99999999L}) EXPECT_FALSE(folder.open(number).descriptor.is_open());
}

TEST_F(Folders, LinksLeadNowhereOutside) {
  fs::create_symlink("../outside/secret.ply", root / "work/link.ply");
  fs::create_symlink("/etc/passwd", root / "work/passwd.txt");
  fs::create_directory_symlink("../outside", root / "work/out");
  fs::create_directory_symlink(".", root / "work/round");
  fs::create_symlink("hull.ply", root / "work/inside.ply");
  fs::create_symlink(".bashrc", root / "work/bashrc.txt");
  put("work/.bashrc", "");
  Folder folder(work());
  EXPECT_EQ(names(folder.list()), (std::vector<std::string>{"deep/net.json", "hull.ply"}))
      << "a link inside is the file that it leads to";
}

// Between listing and opening somebody puts a link in the place of the file, or of a folder above it.
TEST_F(Folders, AFileThatBecameALinkIsNotOpened) {
  put("outside/net.json", "secret");
  Folder folder(work());
  const Listing listing = folder.list();
  fs::remove_all(root / "work/deep");
  fs::create_directory_symlink("../outside", root / "work/deep");
  fs::remove(root / "work/hull.ply");
  fs::create_symlink("../outside/secret.ply", root / "work/hull.ply");
  for (const ListedFile& file : listing.files)
    EXPECT_FALSE(folder.open(file.number).descriptor.is_open()) << file.name;
}

TEST_F(Folders, WriteNewFilesAndReplaceOnRequest) {
  Folder folder(work());
  const Written written = folder.write("new one.ply", std::string("a\0b", 3), false);
  ASSERT_EQ(written.outcome, Outcome::Done) << written.sentence;
  EXPECT_EQ(get("work/new one.ply"), std::string("a\0b", 3));
  EXPECT_EQ(content(folder.open(written.number)), std::string("a\0b", 3));
  EXPECT_EQ(folder.write("hull.ply", "x", false).outcome, Outcome::Exists);
  EXPECT_EQ(get("work/hull.ply"), "hull");
  EXPECT_EQ(folder.write("hull.ply", "x", true).outcome, Outcome::Done);
  EXPECT_EQ(get("work/hull.ply"), "x");
  int n = 0;
  for ([[maybe_unused]] const auto& entry : fs::directory_iterator(root / "work")) ++n;
  EXPECT_EQ(n, 3) << "no temporary files are left";
}

TEST_F(Folders, WritingFollowsNoLink) {
  fs::create_symlink("../outside/secret.ply", root / "work/link.ply");
  Folder folder(work());
  EXPECT_EQ(folder.write("link.ply", "x", false).outcome, Outcome::Exists);
  EXPECT_EQ(folder.write("link.ply", "x", true).outcome, Outcome::Done);
  EXPECT_EQ(get("outside/secret.ply"), "secret");
  EXPECT_FALSE(fs::is_symlink(root / "work/link.ply"));
  fs::create_directory(root / "work/folder.ply");
  EXPECT_EQ(folder.write("folder.ply", "x", true).outcome, Outcome::Failed);
}

// For what is written bit by bit: the name is taken before anything is in the file.
TEST_F(Folders, BeginAFileThatWasNotThere) {
  fs::create_symlink("../outside/new.blog", root / "work/link.blog");
  Folder folder(work());
  const Written made = folder.begin("new.blog");
  ASSERT_EQ(made.outcome, Outcome::Done) << made.sentence;
  std::ofstream(folder.path("new.blog")) << "x";
  EXPECT_EQ(content(folder.open(made.number)), "x");
  EXPECT_EQ(names(folder.list()), (std::vector<std::string>{"deep/net.json", "hull.ply", "new.blog"}));
  EXPECT_EQ(folder.begin("new.blog").outcome, Outcome::Exists);
  EXPECT_EQ(folder.begin("link.blog").outcome, Outcome::Exists);
  EXPECT_FALSE(fs::exists(root / "outside/new.blog"));
  EXPECT_EQ(folder.begin("../new.blog").outcome, Outcome::BadName);
  folder.take_back("new.blog");
  EXPECT_FALSE(fs::exists(root / "work/new.blog"));
}

TEST_F(Folders, WriteNoNamesThatMeanMore) {
  Folder folder(work());
  for (const std::string& name :
       {std::string(), std::string("."), std::string(".."), std::string("../x.ply"), std::string("/x.ply"),
        std::string("deep/x.ply"), std::string("..\\x.ply"), std::string(".x.ply"), std::string("x\n.ply"),
        std::string("x\0.ply", 6), std::string("x.ply\0", 6), std::string("x.sh"), std::string("x.desktop"),
        std::string("x"), std::string("x.ply.gz"), std::string("x.exe"), std::string(200, 'x') + ".ply"})
    EXPECT_EQ(folder.write(name, "x", true).outcome, Outcome::BadName) << name;
  EXPECT_EQ(folder.write("Rümpf – 2.step", "x", false).outcome, Outcome::Done);
}

TEST_F(Folders, AFileAloneIsSeenAlone) {
  Folder folder((root / "work/hull.ply").string());
  EXPECT_EQ(folder.first(), 0);
  EXPECT_EQ(names(folder.list()), std::vector<std::string>{"hull.ply"});
  EXPECT_EQ(content(folder.open(0)), "hull");
  folder.write("b.ply", "b", false);
  EXPECT_EQ(names(folder.list()), (std::vector<std::string>{"b.ply", "hull.ply"}));
  EXPECT_THROW(Folder((root / "nowhere").string()), FileError);
}

TEST_F(Folders, ManyFilesAreCutOff) {
  for (std::size_t k = 0; k < Folder::kMostFiles; ++k) put("work/n" + std::to_string(k) + ".off", "");
  const Listing listing = Folder(work()).list();
  EXPECT_EQ(listing.files.size(), Folder::kMostFiles);
  EXPECT_EQ(listing.left_out, 2U);
}

}  // namespace
}  // namespace batten::studio
