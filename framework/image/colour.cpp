#include "image/colour.h"

#include "core/error.h"

#include <ImathMatrix.h>

#include <array>
#include <cmath>
#include <exception>

namespace restirpg {
namespace {

using Imath::M44f;
using Imath::V2f;
using Imath::V3f;

/// Cone responses of CIE XYZ; row vectors, as in OpenEXR.  [Lam 1985; SMPTE RP 2065-4]
const M44f BRADFORD(0.8951f, -0.7502f, 0.0389f, 0, 0.2664f, 1.7135f, -0.0685f, 0, -0.1614f, 0.0367f, 1.0296f, 0, 0, 0,
                    0, 1);

bool equal(V2f a, V2f b)
{
    // Files round to float, and standards to four digits.
    return a.equalWithAbsError(b, 1e-4f);
}

bool equal(const Imf::Chromaticities& a, const Imf::Chromaticities& b)
{
    return equal(a.red, b.red) && equal(a.green, b.green) && equal(a.blue, b.blue) && equal(a.white, b.white);
}

V3f coneResponse(V2f chromaticity)
{
    const V3f xyz(chromaticity.x / chromaticity.y, 1, (1 - chromaticity.x - chromaticity.y) / chromaticity.y);
    return xyz * BRADFORD;
}

M44f adaptation(V2f from, V2f to)
{
    const V3f ratio = coneResponse(to) / coneResponse(from);
    M44f scale;
    scale.setScale(ratio);
    return BRADFORD * scale * BRADFORD.inverse();
}

M44f conversion(const Imf::Chromaticities& from, V2f neutral)
{
    const Imf::Chromaticities rec709;
    const M44f fromXyz = Imf::XYZtoRGB(rec709, 1);
    if (equal(from, CIE_XYZ))
        return fromXyz;
    return Imf::RGBtoXYZ(from, 1) * adaptation(neutral, rec709.white) * fromXyz;
}

bool spansColours(const Imf::Chromaticities& from, V2f neutral, const M44f& matrix)
{
    const V2f a = from.green - from.red, b = from.blue - from.red;
    bool finite = std::abs(a.x * b.y - a.y * b.x) > 1e-6f && neutral.y > 0 && from.white.y > 0;
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j)
            finite = finite && std::isfinite(matrix[i][j]);
    return finite;
}

}  // namespace

void toRec709(const std::string& place, Image& image, const Imf::Chromaticities& from, V2f neutral)
{
    if (equal(from, Imf::Chromaticities()) && equal(neutral, from.white))
        return;
    M44f matrix;
    bool valid = true;
    try {
        matrix = conversion(from, neutral);
    } catch (const std::exception&) {
        valid = false;
    }
    if (!valid || !spansColours(from, neutral, matrix))
        fail("{}: cannot read: its chromaticities (red {:g},{:g} green {:g},{:g} blue {:g},{:g} white {:g},{:g}) are "
             "not those of three primaries; write it again as linear Rec.709",
             place, from.red.x, from.red.y, from.green.x, from.green.y, from.blue.x, from.blue.y, from.white.x,
             from.white.y);
    for (size_t i = 0; i + 2 < image.data.size(); i += 3) {
        const V3f rgb = V3f(image.data[i], image.data[i + 1], image.data[i + 2]) * matrix;
        image.data[i] = rgb.x;
        image.data[i + 1] = rgb.y;
        image.data[i + 2] = rgb.z;
    }
}

}  // namespace restirpg
