#include "render/png.h"

#include <fstream>

#include <gmock/gmock.h>
#include <unistd.h>

namespace wry::render {
namespace {

using ::testing::HasSubstr;

class Png : public ::testing::Test {
protected:
  void SetUp() override {
    m_folder = std::filesystem::temp_directory_path() / fmt::format("wry_png_test_{}", ::getpid());
    std::filesystem::create_directories(m_folder);
  }
  void TearDown() override { std::filesystem::remove_all(m_folder); }
  std::filesystem::path path() const { return m_folder / "picture.png"; }

  std::filesystem::path m_folder;
};

Image pattern(int width, int height) {
  Image image(width, height);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      std::uint8_t* pixel = image.at(x, y);
      pixel[0] = static_cast<std::uint8_t>(x * 7 + y);
      pixel[1] = static_cast<std::uint8_t>(x * y);
      pixel[2] = static_cast<std::uint8_t>(255 - x);
      pixel[3] = static_cast<std::uint8_t>(40 + y);
    }
  }
  return image;
}

TEST_F(Png, KeepsEveryPixelAndText) {
  const Image image = pattern(61, 37);
  PngSettings settings;
  settings.alpha = PngAlpha::straight;
  const std::vector<PngText> texts = {{"shot", "bunny"}, {"material", "E = 5\u00b710\u2074 Pa"}, {"frame", "0042"}};
  ASSERT_TRUE(write_png(path(), image, texts, settings).ok());
  const Result<PngContents> read = read_png(path());
  ASSERT_TRUE(read.ok()) << read.error().message;
  EXPECT_EQ(read->image.pixels, image.pixels);
  ASSERT_EQ(read->texts.size(), texts.size());
  for (std::size_t i = 0; i < texts.size(); ++i) {
    EXPECT_EQ(read->texts[i].key, texts[i].key);
    EXPECT_EQ(read->texts[i].value, texts[i].value);
  }
}

TEST_F(Png, WithoutAlphaIsOpaque) {
  const Image image = pattern(20, 20);
  ASSERT_TRUE(write_png(path(), image, {}).ok());
  const Result<PngContents> read = read_png(path());
  ASSERT_TRUE(read.ok());
  EXPECT_EQ(read->image.at(3, 4)[0], image.at(3, 4)[0]);
  EXPECT_EQ(read->image.at(3, 4)[3], 255);
}

TEST_F(Png, NoticesEveryTruncation) {
  const Result<std::vector<std::uint8_t>> bytes = encode_png(pattern(40, 30), {{"shot", "bunny"}});
  ASSERT_TRUE(bytes.ok());
  for (std::size_t kept = 0; kept < bytes->size(); kept += 97) {
    std::ofstream(path(), std::ios::binary)
        .write(reinterpret_cast<const char*>(bytes->data()), static_cast<std::streamsize>(kept));
    const Status whole = png_is_whole(path());
    ASSERT_FALSE(whole.ok()) << kept << " of " << bytes->size() << " bytes";
    EXPECT_EQ(whole.error().code, ErrorCode::io);
  }
}

TEST_F(Png, NoticesOneFlippedBit) {
  std::vector<std::uint8_t> bytes = *encode_png(pattern(40, 30), {});
  bytes[bytes.size() / 2] ^= 4U;
  std::ofstream(path(), std::ios::binary)
      .write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  EXPECT_FALSE(png_is_whole(path()).ok());
}

TEST_F(Png, MissingFileIsMissingInput) {
  const Status whole = png_is_whole(m_folder / "nowhere.png");
  ASSERT_FALSE(whole.ok());
  EXPECT_EQ(whole.error().code, ErrorCode::missing_input);
}

TEST_F(Png, FolderThatIsNotThereCannotBeWritten) {
  const Status written = write_png(m_folder / "no" / "such" / "picture.png", pattern(4, 4), {});
  ASSERT_FALSE(written.ok());
  EXPECT_EQ(written.error().code, ErrorCode::cannot_write);
  EXPECT_THAT(written.error().message, HasSubstr("picture.png"));
}

TEST_F(Png, LeavesNoPartBehind) {
  ASSERT_TRUE(write_png(path(), pattern(4, 4), {}).ok());
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(m_folder), {}), 1);
}

TEST_F(Png, RefusesKeysThatPngDoesNotAllow) {
  EXPECT_FALSE(encode_png(pattern(4, 4), {{"", "x"}}).ok());
  EXPECT_FALSE(encode_png(pattern(4, 4), {{std::string(80, 'k'), "x"}}).ok());
  EXPECT_FALSE(encode_png(Image(), {}).ok());
}

} // namespace
} // namespace wry::render
