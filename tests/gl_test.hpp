// The GL context of a test program: the one named by TESSERA_TEST_CONTEXT (osmesa or egl), made once.
#pragma once

#include <gtest/gtest.h>

#include "engine/gl/context.hpp"

namespace tessera::test {

/// The program's context, current. Never null inside a test: a program without its context fails as a whole.
gl::Context& context();

/// Base of every GL test: an error-severity debug message fails the test.
class GlTest : public ::testing::Test {
 protected:
  void SetUp() override;
  void TearDown() override;
};

}  // namespace tessera::test
