/// Text for people.
#include <gtest/gtest.h>
#include <mrpt/core/exceptions.h>

#include "commands/terminal.h"

using namespace loopline;

TEST(Wrapped, breaks_at_blanks_and_indents) {
    EXPECT_EQ(wrapped("aa bb cc", 6, 2, 0), "aa bb\n  cc");
    EXPECT_EQ(wrapped("aa bb cc", 8, 2, 4), "aa\n  bb cc");
    EXPECT_EQ(wrapped("longer_than_all b", 6, 1, 0), "longer_than_all\n b");
    EXPECT_EQ(wrapped("a\nb", 10, 2, 0), "a\n  b");
    EXPECT_EQ(wrapped("\xC3\xBC\xC3\xBC bb", 7, 0, 0), "\xC3\xBC\xC3\xBC bb") << "letters count, not bytes";
    EXPECT_EQ(wrapped("", 10, 2, 0), "");
}

TEST(PlainMessage, keeps_the_sentence_of_an_mrpt_exception_and_drops_its_stack) {
    try {
        THROW_EXCEPTION("no such map\nat all");
    } catch (const std::exception& e) {
        ASSERT_NE(std::string(e.what()).find("Call stack"), std::string::npos);
        EXPECT_EQ(plain_message(e.what()), "no such map at all");
    }
    EXPECT_EQ(plain_message("plain Message: with words"), "plain Message: with words");
    EXPECT_EQ(plain_message(""), "");
}
