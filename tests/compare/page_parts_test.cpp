// SPDX-License-Identifier: MIT
#include "compare/report/page.h"

#include <gtest/gtest.h>

#include "compare/comparison.h"
#include "image/encoded_image.h"

namespace alidade::test {

using namespace image;
using namespace compare;

namespace {

TEST(PagePartsTest, inserted_text_is_not_expanded_again) {
  EXPECT_EQ(fill_page("<{{a}}|{{b}}>", {{"a", "{{b}}"}, {"b", "x"}}), "<{{b}}|x>");
}

TEST(PagePartsTest, text_in_html_is_text) {
  EXPECT_EQ(html_text("<b a='1' c=\"2\">&"), "&lt;b a=&#39;1&#39; c=&quot;2&quot;&gt;&amp;");
}

TEST(PagePartsTest, json_cannot_end_its_script_element) {
  EXPECT_EQ(script_json("{\"a\":\"</script><!--\"}"), "{\"a\":\"\\u003c/script>\\u003c!--\"}");
}

// Test vectors of RFC 4648, section 10.
TEST(PagePartsTest, base64_is_that_of_rfc_4648) {
  const auto encoded = [](const std::string& text) {
    return base64({reinterpret_cast<const unsigned char*>(text.data()), text.size()});
  };
  EXPECT_EQ(encoded(""), "");
  EXPECT_EQ(encoded("f"), "Zg==");
  EXPECT_EQ(encoded("fo"), "Zm8=");
  EXPECT_EQ(encoded("foo"), "Zm9v");
  EXPECT_EQ(encoded("foob"), "Zm9vYg==");
  EXPECT_EQ(encoded("fooba"), "Zm9vYmE=");
  EXPECT_EQ(encoded("foobar"), "Zm9vYmFy");
}

TEST(PagePartsTest, shrunk_images_have_means_of_squares) {
  const ByteImage image{3, 2, {10, 0, 0, 20, 0, 0, 7, 8, 9, 30, 0, 0, 40, 0, 0, 7, 8, 9}};
  const ByteImage small = shrunk(image, 2);
  EXPECT_EQ(small.width, 2);
  EXPECT_EQ(small.height, 1);
  EXPECT_EQ(small.bytes, (std::vector<std::uint8_t>{25, 0, 0, 7, 8, 9}));
  EXPECT_EQ(shrunk(image, 3).bytes, image.bytes);
}

TEST(PagePartsTest, images_are_packed_as_requested) {
  const ByteImage image{2, 1, {1, 2, 3, 250, 251, 252}};
  EXPECT_TRUE(data_url(image, ImagePacking::automatic).starts_with("data:image/png;base64,iVBORw0KGgo"));
  EXPECT_TRUE(data_url(image, ImagePacking::jpeg).starts_with("data:image/jpeg;base64,/9j/"));
  EXPECT_EQ(packing_for(ImagePacking::automatic, 2'000'000), ImagePacking::png);
  EXPECT_EQ(packing_for(ImagePacking::automatic, 2'000'001), ImagePacking::jpeg);
}

TEST(PagePartsTest, histograms_take_what_lies_outside_into_their_ends_and_leave_out_nan) {
  const std::vector<float> values{
      -1.0f, 0.0f, 0.49f, 0.5f, 1.0f, 5.0f, std::numeric_limits<float>::quiet_NaN(), 0.2f};
  const ImageMask mask{{1, 1, 1, 1, 1, 1, 1, 0}};
  const Histogram histogram = count_values("x", values, mask, 0.0, 1.0, 2);
  EXPECT_EQ(histogram.bins, (std::vector<std::uint64_t>{3, 3}));
}

}  // namespace
}  // namespace alidade::test
