#include "batten/io/file.hpp"

#include "scratch.hpp"

#include <filesystem>
#include <fstream>
#include <sstream>

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/file.h>
#include <sys/wait.h>
#include <unistd.h>
#include <zlib.h>

namespace batten {
namespace {

using test::scratch_file;

std::string plain(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

void write_plain(const std::string& path, const std::string& bytes) {
  std::ofstream(path, std::ios::binary) << bytes;
}

std::vector<std::string> lines_of(LineReader in) {
  std::vector<std::string> lines;
  std::string_view line;
  while (in.next(line)) {
    lines.emplace_back(line);
    EXPECT_EQ(in.line_number(), static_cast<long>(lines.size()));
  }
  return lines;
}

size_t files_in(const std::string& folder) {
  const std::filesystem::directory_iterator begin(folder);
  return static_cast<size_t>(std::distance(begin, std::filesystem::directory_iterator()));
}

TEST(FileExtension, IsWhatFollowsTheLastDotOfTheName) {
  EXPECT_EQ(file_extension("A/b.PLY"), "ply");
  EXPECT_EQ(file_extension("bunny.off.gz"), "off");
  EXPECT_EQ(file_extension("a.b/c"), "");
  EXPECT_EQ(file_extension("a.b\\c"), "");
  EXPECT_EQ(file_extension("a.b/c.Obj"), "obj");
  EXPECT_EQ(file_extension("plain"), "");
  EXPECT_EQ(file_extension("a.gz"), "");
}

// However lines end, whatever mark stands in front, and where a block of the reader ends: a line is a line.
TEST(LineReader, KnowsEveryLineEnd) {
  EXPECT_EQ(lines_of(LineReader("a\nb\r\n\nc", "memory")), (std::vector<std::string>{"a", "b", "", "c"}));
  EXPECT_EQ(lines_of(LineReader("\xEF\xBB\xBF"
                                "a\n",
                                "memory")),
            std::vector<std::string>{"a"});
  EXPECT_TRUE(lines_of(LineReader("", "memory")).empty());
  const std::string path = scratch_file("lines.txt");
  write_plain(path,
              "\xEF\xBB\xBF"
              "first\r\nlast");
  EXPECT_EQ(lines_of(LineReader(path)), (std::vector<std::string>{"first", "last"}));
  // Lines of a prime length over several blocks of a megabyte.
  std::string text;
  std::vector<std::string> expected;
  for (int k = 0; text.size() < size_t{5} << 20; ++k) {
    expected.push_back(std::string(997, static_cast<char>('a' + k % 26)));
    text += expected.back() + "\n";
  }
  write_plain(path, text);
  EXPECT_EQ(lines_of(LineReader(path)), expected);
}

TEST(LineReader, RefusesWhatIsNoText) {
  const std::string path = scratch_file("binary.txt");
  write_plain(path, std::string("text\n\0more\n", 11));
  EXPECT_THROW(lines_of(LineReader(path)), FileError);
  EXPECT_THROW(lines_of(LineReader(std::string("a\0b", 3), "memory")), FileError);
  // Behind the first megabytes too.
  std::string text;
  for (int k = 0; k < 30000; ++k) text += std::string(99, 'x') + "\n";
  write_plain(path, text + '\0');
  EXPECT_THROW(lines_of(LineReader(path)), FileError);
  // 64 MiB without an end of line is no text; the message names the line.
  {
    std::ofstream out(path, std::ios::binary);
    out << "one\n";
    const std::string block(size_t{1} << 20, 'x');
    for (int k = 0; k < 67; ++k) out << block;
  }
  try {
    lines_of(LineReader(path));
    ADD_FAILURE() << "accepted";
  } catch (const FileError& error) {
    EXPECT_NE(std::string(error.what()).find("no end"), std::string::npos) << error.what();
  }
  std::filesystem::remove(path);
  EXPECT_THROW(LineReader{path}, FileError);
  EXPECT_THROW(read_file(test::scratch()), FileError);
}

// gzip is told by its content, not by the name; half a file is an error and not half a content.
TEST(ReadFile, UnpacksGzipAndSaysWhereItIsDamaged) {
  std::string content;
  for (int k = 0; k < 200000; ++k) content += std::to_string(k * 7919) + (k % 3 == 0 ? "\n" : " ");
  const std::string path = scratch_file("packed.txt");
  gzFile out = gzopen(path.c_str(), "wb");
  ASSERT_EQ(gzwrite(out, content.data(), static_cast<unsigned>(content.size())),
            static_cast<int>(content.size()));
  gzclose(out);
  EXPECT_TRUE(read_file(path) == content);
  const std::string packed = plain(path);
  ASSERT_LT(packed.size(), content.size());
  write_plain(path, packed.substr(0, packed.size() / 2));
  EXPECT_THROW(read_file(path), FileError);
  std::string damaged = packed;
  for (size_t k = damaged.size() / 2; k < damaged.size() / 2 + 20; ++k) damaged[k] ^= 0x55;
  write_plain(path, damaged);
  EXPECT_THROW(read_file(path), FileError);
}

// Until commit() nobody sees anything, and without it nothing is left behind.
// 80 MB of zeros are 80 kB: nobody's mesh. What is not compressed may be as long as it likes.
TEST(ReadFile, StopsWhatUnpacksToFarMoreThanItsSize) {
  const std::string path = test::scratch_file("bomb.obj.gz");
  gzFile file = gzopen(path.c_str(), "wb9");
  const std::string block(size_t{1} << 20, '0');
  for (int i = 0; i < 80; ++i) gzwrite(file, block.data(), static_cast<unsigned>(block.size()));
  gzclose(file);
  try {
    read_file(path);
    FAIL();
  } catch (const FileError& error) {
    EXPECT_NE(std::string(error.what()).find("100 times"), std::string::npos) << error.what();
  }
  const std::string plain = test::scratch_file("plain.obj");
  {
    std::ofstream out(plain);
    for (int i = 0; i < 80; ++i) out << block;
  }
  EXPECT_EQ(read_file(plain).size(), 80 * block.size());
  // A small file may repeat itself as it likes.
  file = gzopen(path.c_str(), "wb9");
  gzwrite(file, block.data(), static_cast<unsigned>(block.size()));
  gzclose(file);
  EXPECT_EQ(read_file(path), block);
}

TEST(OutputFile, AppearsWholeOrNotAtAll) {
  const std::string folder = scratch_file("out");
  std::filesystem::create_directories(folder);
  const std::string path = folder + "/file.txt";
  write_file(path, "old");
  EXPECT_EQ(plain(path), "old");
  {
    OutputFile out(path);
    out.write("half");
    EXPECT_EQ(plain(path), "old");
    EXPECT_EQ(files_in(folder), 2u);
  }
  EXPECT_EQ(plain(path), "old");
  EXPECT_EQ(files_in(folder), 1u);
  {
    OutputFile out(path);
    out.write("ne");
    out.write("w");
    out.commit();
  }
  EXPECT_EQ(plain(path), "new");
  EXPECT_EQ(files_in(folder), 1u);
  EXPECT_THROW(OutputFile(folder + "/missing/file.txt"), FileError);
  EXPECT_THROW(OutputFile{folder}, FileError);
}

// A link is followed: the file behind it is replaced, and the link stays one.
// A name of a process that is gone, of one that runs, and of no process at all.
TEST(OutputFile, RemovesWhatAKilledProcessHasLeft) {
  const std::string path = test::scratch_file("model.ply");
  const pid_t child = fork();
  if (child == 0) _exit(0);
  ASSERT_EQ(waitpid(child, nullptr, 0), child);
  const std::string gone = path + ".part-" + std::to_string(child) + "-0123abcd",
                    running = path + ".part-" + std::to_string(getpid()) + "-0123abcd",
                    other = path + ".part-x",
                    beside = test::scratch_file("other.ply.part-") + std::to_string(child) + "-0123abcd";
  for (const std::string& name : {gone, running, other, beside}) std::ofstream(name) << "half";
  write_file(path, "whole");
  EXPECT_FALSE(std::filesystem::exists(gone));
  for (const std::string& name : {path, running, other, beside})
    EXPECT_TRUE(std::filesystem::exists(name)) << name;
  // A lock says that somebody writes it, who has his numbers from another container.
  std::ofstream(gone) << "half";
  const int held = open(gone.c_str(), O_RDONLY);
  ASSERT_EQ(flock(held, LOCK_EX | LOCK_NB), 0);
  write_file(path, "again");
  EXPECT_TRUE(std::filesystem::exists(gone));
  close(held);
  write_file(path, "again");
  EXPECT_FALSE(std::filesystem::exists(gone));
}

TEST(OutputFile, TellsThatTheDiskIsFull) {
  const std::string full = "/dev/full";
  if (!std::filesystem::exists(full)) GTEST_SKIP() << "this system has no " << full;
  try {
    write_file(full, "text");
    ADD_FAILURE() << "accepted";
  } catch (const FileError& error) {
    EXPECT_NE(std::string(error.what()).find("cannot be written: No space"), std::string::npos)
        << error.what();
  }
}

TEST(OutputFile, FollowsLinks) {
  const std::string target = scratch_file("target.txt"), link = scratch_file("link.txt");
  write_file(target, "old");
  std::filesystem::remove(link);
  std::filesystem::create_symlink(target, link);
  write_file(link, "new");
  EXPECT_TRUE(std::filesystem::is_symlink(link));
  EXPECT_EQ(plain(target), "new");
}

}  // namespace
}  // namespace batten
