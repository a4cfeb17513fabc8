// What astropy writes is in tests/files.
#include "formats/bad_files.hpp"
#include "formats/fits.hpp"

using namespace files;

TEST_CASE("FITS files say which voxels have no value, and may have Fortran's numbers", "[fits]") {
  const Folder folder;
  const auto source = open_volume(
      write(folder / "a.fits",
            fits_cube(16, {{"BLANK", "-7 / none"}, {"BSCALE", "5D-1"}, {"BUNIT", "'Jy/beam ' / of"}}) +
                samples<short>(true)));
  CHECK(source->grid().type == ScalarType::float32);
  CHECK(source->concurrent());
  CHECK(source->notes().fill == -3.5);
  CHECK(source->notes().quantity == "Jy/beam");
}

TEST_CASE("FITS files without a cube, or damaged, are refused", "[fits][bad]") {
  const auto voxels = samples<short>(true);
  const auto of = [&](const std::map<std::string, std::string>& cards) {
    return fits_cube(16, cards) + voxels;
  };
  const auto flat = fits({{"BITPIX", "8"}, {"NAXIS", "2"}, {"NAXIS1", "10"}, {"NAXIS2", "10"}});
  check_all({
      file("prose", "its data ends at byte 5", "a.fits", "hello"),
      file("long prose", "does not begin as FITS files do", "a.fits", std::string(3000, 'x')),
      file("no end", "its data ends at byte", "a.fits", of({}).substr(0, 80) + std::string(3000, ' ')),
      file("gzip without an end", "a header has no end", "a.fits.gz",
           gzip("SIMPLE  = T" + std::string(3000 * 1000, ' '))),
      file("cut short", "promises 120 bytes of voxels, the file holds 119", "a.fits",
           of({}).substr(0, 2880 + 119)),
      file("a picture", "it holds no image of three axes", "a.fits", flat + std::string(2880, ' ')),
      file("a table", "it holds no image of three axes", "a.fits",
           fits({{"NAXIS", "0"}}) + fits_cube(8, {}, "XTENSION= 'BINTABLE'") + std::string(2880, ' ')),
      file("tiles", "compressed in tiles; hint: decompress it with funpack", "a.fits",
           fits({{"NAXIS", "0"}}) + fits({{"NAXIS", "2"}, {"ZIMAGE", "T"}}, "XTENSION= 'BINTABLE'")),
      file("something behind", "does not begin as FITS", "a.fits", std::string(2880, ' ') + of({})),
      file("64 bits", "voxels of BITPIX 64 cannot be rendered", "a.fits", fits_cube(64) + voxels),
      file("no bits", "voxels of BITPIX 0 cannot be rendered", "a.fits", of({{"BITPIX", "0"}})),
      file("words", "NAXIS1 is 'five'", "a.fits", of({{"NAXIS1", "five / columns"}})),
      file("negative", "NAXIS2 is -4", "a.fits", of({{"NAXIS2", "-4"}})),
      file("parts", "NAXIS2 is 3.5", "a.fits", of({{"NAXIS2", "3.5"}})),
      file("none", "5 x 4 x 0", "a.fits", of({{"NAXIS3", "0"}})),
      file("huge", "overflow 64 bits", "a.fits",
           of({{"NAXIS1", "2000000000"}, {"NAXIS2", "2000000000"}, {"NAXIS3", "2000000000"}})),
      file("huge data before", "overflow 64 bits", "a.fits",
           fits({{"BITPIX", "64"}, {"NAXIS", "2"}, {"NAXIS1", "2000000000"}, {"NAXIS2", "2000000000"}})),
      file("many axes", "axes behind the third are too long", "a.fits",
           of({{"NAXIS", "5"}, {"NAXIS4", "2000000000"}, {"NAXIS5", "2"}})),
      file("no steps", "spacing 0 2 3", "a.fits",
           of({{"CUNIT1", "'mm'"},
               {"CUNIT2", "'mm'"},
               {"CUNIT3", "'mm'"},
               {"CDELT1", "0"},
               {"CDELT2", "2"},
               {"CDELT3", "3"}})),
  });
}
