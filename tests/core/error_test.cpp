// Messages hold whatever names a user's files have: one line each, valid UTF-8, no control characters.
#include "core/error.h"

#include <gtest/gtest.h>

namespace restirpg {
namespace {

template <typename Action>
std::string errorOf(Action action)
{
    try {
        action();
    } catch (const Error& error) {
        return error.what();
    }
    return {};
}

TEST(Error, OrdinaryTextStaysAsItIs)
{
    for (const char* text : {"", "plain", "Küche, 台所, кухня, 🛋", "a\\b 'quoted'"})
        EXPECT_EQ(escaped(text), text);
}

TEST(Error, ControlCharactersAndMarksOfDirectionAreEscaped)
{
    EXPECT_EQ(escaped("\x1b]0;title\x07"), "\\x1b]0;title\\x07");
    EXPECT_EQ(escaped("a\r\n\tb\x7f"), "a\\r\\n\\tb\\x7f");
    EXPECT_EQ(escaped(std::string_view("a\0b", 3)), "a\\x00b");
    EXPECT_EQ(escaped("\xc2\x9b"
                      "31m"),
              "\\x9b31m");  // CSI as one character
    EXPECT_EQ(escaped("gpj.\xe2\x80\xae"
                      "exe"),
              "gpj.\\u202eexe");
    EXPECT_EQ(escaped("a\xe2\x80\xa8"
                      "b"),
              "a\\u2028b");
    EXPECT_EQ(escaped("a\nb\x1b", Breaks::kept), "a\nb\\x1b");
}

TEST(Error, BytesThatAreNoUtf8AreEscaped)
{
    EXPECT_EQ(escaped("\xff"
                      "a\xc3"),
              "\\xffa\\xc3");  // cut inside a character
    EXPECT_EQ(escaped("\xe5\x8f"), "\\xe5\\x8f");
    EXPECT_EQ(escaped("\xc0\xaf \xe0\x80\xaf"), "\\xc0\\xaf \\xe0\\x80\\xaf");  // overlong
    EXPECT_EQ(escaped("\xed\xa0\x80"), "\\xed\\xa0\\x80");  // a surrogate
    EXPECT_EQ(escaped("\xf4\x90\x80\x80"), "\\xf4\\x90\\x80\\x80");  // beyond U+10FFFF
    EXPECT_EQ(escaped("\xf4\x8f\xbf\xbf"), "\xf4\x8f\xbf\xbf");
}

TEST(Error, WhatIsShownOfATextEndsBetweenCharacters)
{
    EXPECT_EQ(printable("kurz"), "kurz");
    EXPECT_EQ(printable("abc\xc3\xa9"
                        "def",
                        4),
              "abc...");
    EXPECT_EQ(printable("abc\xc3\xa9"
                        "def",
                        5),
              "abc\xc3\xa9...");
    EXPECT_EQ(printable("ab\xf0\x9f\x9b\x8b"
                        "def",
                        5),
              "ab...");
    EXPECT_EQ(printable("a\nb"), "a\\nb");
}

TEST(Error, AMessageOfFailIsOneLineWhateverItsArguments)
{
    EXPECT_EQ(errorOf([] { fail("{}: {}", "a\nb", "c\x1b\xe5"); }), "a\\nb: c\\x1b\\xe5");
    EXPECT_EQ(errorOf([] { throw Error("one\ntwo\x1b"); }), "one\ntwo\\x1b");
}

}  // namespace
}  // namespace restirpg
