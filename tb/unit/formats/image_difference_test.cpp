#include "formats/image_difference.h"

#include <catch2/catch.hpp>

namespace metabuffer {
namespace {

TEST_CASE("image difference: none between equal pictures") {
    CHECK_FALSE(image_difference(ColourImage(5, 3, 7), ColourImage(5, 3, 7)));
    CHECK_FALSE(image_difference(ColourImage(), ColourImage()));
}

void check_difference(const ColourImage& left, const ColourImage& right, const ImageDifference& wanted) {
    const auto difference = image_difference(left, right);
    REQUIRE(difference);
    CHECK(difference->pixels == wanted.pixels);
    CHECK(difference->x == wanted.x);
    CHECK(difference->y == wanted.y);
    CHECK(difference->left == wanted.left);
    CHECK(difference->right == wanted.right);
}

TEST_CASE("image difference: how many pixels differ, and the first of them row by row with both values") {
    const ColourImage left(5, 3, 0x10);
    ColourImage right = left;
    right.values[5 + 3] = 0x20;  // the second row, of which an earlier column differs only further down
    right.values[10 + 1] = 0x30;
    right.values[10 + 4] = 0x40;  // the last one
    check_difference(left, right, {3, 3, 1, 0x10, 0x20});
    right.values[0] = 0;
    check_difference(right, left, {4, 0, 0, 0, 0x10});
}

}  // namespace
}  // namespace metabuffer
