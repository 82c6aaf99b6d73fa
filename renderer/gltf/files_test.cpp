// Which files are read: those in the scene's folder and no other, and data: URIs; and their hash.
#include <sys/inotify.h>
#include <sys/stat.h>
#include <unistd.h>

#include "gltf/sample_test.h"

using namespace gltf;
using namespace gltf::sample;

TEST(Files, reads_only_regular_files_inside_the_folder_of_the_scene) {
  const Folder outer;
  std::filesystem::create_directories(outer / "in/sub");
  std::filesystem::create_directories(outer / "in/directory");
  File f = triangle();
  const std::string binary(f.binary.begin(), f.binary.end());
  for (const char* name : {"secret.bin", "in/A..B.bin", "in/sub/x.bin", "in/ x.bin", "in/plus+x.bin"})
    outer.write(name, binary);
  std::filesystem::create_symlink(outer / "secret.bin", outer / "in/link.bin");
  std::filesystem::create_symlink(outer / "in/sub/x.bin", outer / "in/inner_link.bin");
  std::filesystem::create_directory_symlink(outer / ".", outer / "in/up");
  ASSERT_EQ(::mkfifo((outer / "in/fifo.bin").c_str(), 0600), 0);
  const int watch = ::inotify_init1(IN_NONBLOCK);
  ASSERT_GE(watch, 0);
  for (const char* name : {"secret.bin", "in/fifo.bin"})
    ASSERT_GE(::inotify_add_watch(watch, (outer / name).c_str(), IN_OPEN | IN_ACCESS), 0) << name;
  const auto with = [&](const std::string& uri) -> std::string {
    f.root["buffers"][0]["uri"] = uri;
    const std::string file = outer.write("in/scene.gltf", f.root.dump());
    try {
      load(file);
    } catch (const base::Error& error) {
      return error.what();
    }
    return "";
  };
  for (const std::string good : {"A..B.bin", "sub/x.bin", "%20x.bin", " x.bin", "%41..B.bin", "./sub/x.bin",
                                 "plus+x.bin", "inner_link.bin"})
    EXPECT_EQ(with(good), "") << good;
  // A file that is only in the current directory is not the scene's.
  const std::filesystem::path before = std::filesystem::current_path();
  std::filesystem::current_path(outer / ".");
  const std::string from_here = with("secret.bin");
  std::filesystem::current_path(before);
  expect_refused(from_here, "buffers[0].uri");
  for (const std::string bad : {"../secret.bin",
                                "sub/../sub/x.bin",
                                "sub/../../secret.bin",
                                "%2e%2e/secret.bin",
                                "..%2fsecret.bin",
                                "..%2Fsecret.bin",
                                "link.bin",
                                "up/secret.bin",
                                "fifo.bin",
                                "directory",
                                ".",
                                "",
                                "/etc/hostname",
                                "file:///etc/hostname",
                                "http://localhost/x",
                                "C:\\x",
                                "C:/x",
                                "\\\\host\\x",
                                "//host/x",
                                "missing.bin",
                                "%zz",
                                "%2",
                                "x%00.bin",
                                "sub\\x.bin"})
    expect_refused(with(bad), "buffers[0].uri");
  expect_refused(with(std::string("sub/x.bin\0.png", 14)), "buffers[0].uri");
  // Nobody has so much as opened what must not be read; and this test would have noticed.
  char event[4096];
  EXPECT_EQ(::read(watch, event, sizeof event), -1);
  std::ifstream(outer / "secret.bin").get();
  EXPECT_GT(::read(watch, event, sizeof event), 0);
  ::close(watch);
}

TEST(Files, reads_data_uris_strictly) {
  File f = triangle();
  const auto with = [&](const std::string& uri) {
    f.root["buffers"][0]["uri"] = uri;
    return complaint(f.root.dump());
  };
  const std::string good = base64(f.binary);
  EXPECT_EQ(with("data:application/octet-stream;base64," + good), "");
  EXPECT_EQ(with("data:;base64," + good + base64({0, 0, 0})), "");  // longer than byteLength is fine
  for (const std::string& bad :
       {"data:application/octet-stream;base64" + good, "data:text/plain," + good,
        "data:;base64," + good.substr(0, good.size() / 2), "data:;base64,!" + good.substr(1),
        std::string("data:"), std::string("data:;base64,")})
    expect_refused(with(bad), "buffers[0]");
}

TEST(Files, hashes_the_scene_file_and_what_it_names_in_order) {
  // A self-contained file hashes as sha256sum prints it: `printf '{"asset":{"version":"2.0"}}' | sha256sum`.
  EXPECT_EQ(load_bytes(R"({"asset":{"version":"2.0"}})").hash,
            "f74cabc3532658af0aa3e7abdd6939d22aa5cd78849dc06e3817248fe1c3788d");
  // And with external files: cat scene.gltf b.bin a.png | sha256sum.
  const Folder folder;
  folder.write("b.bin", "0123456789abcdef");
  folder.write("a.png", "not decoded");
  const std::string text =
      R"({"asset":{"version":"2.0"},"buffers":[{"byteLength":4,"uri":"b.bin"}],"images":[{"uri":"a.png"}]})";
  EXPECT_EQ(load(folder.write("scene.gltf", text)).hash,
            "ce8003dcf71154022d5009294087e3a869652c8e01a0185001c45678549b162f");
}
