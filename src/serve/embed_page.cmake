# Writes OUTPUT, a C++ source with the bytes of FOLDER's index.html, which gets the style sheet and all modules, so that a
# browser asks once.
cmake_minimum_required(VERSION 3.19)

# Appends a module to the script, after those that it imports: a function that returns what it exports.
function(add_module name)
  get_property(added GLOBAL PROPERTY modules)
  if(name IN_LIST added)
    return()
  endif()
  set_property(GLOBAL APPEND PROPERTY modules ${name})
  file(READ ${FOLDER}/${name}.js text)
  string(REGEX MATCHALL "from '\\./[a-z_]+\\.js'" imports "${text}")
  foreach(import IN LISTS imports)
    string(REGEX REPLACE ".*/([a-z_]+)\\.js'" "\\1" needed ${import})
    add_module(${needed})
  endforeach()
  string(REGEX MATCHALL "\nexport (class|const|function) [A-Za-z0-9_]+" exports "${text}")
  list(TRANSFORM exports REPLACE ".* " "")
  list(JOIN exports ", " exports)
  string(REGEX REPLACE "import ({[^}]*}) from '\\./([a-z_]+)\\.js';" "const \\1 = in_\\2;" text "${text}")
  string(REPLACE "\nexport " "\n" text "${text}")
  set_property(GLOBAL APPEND_STRING PROPERTY script
    "const in_${name} = (() => {\n${text}return { ${exports} };\n})();\n")
endfunction()

add_module(app)
get_property(script GLOBAL PROPERTY script)
file(READ ${FOLDER}/style.css style)
file(READ ${FOLDER}/index.html page)
foreach(part "<link rel=\"stylesheet\" href=\"style.css\">" "<script type=\"module\" src=\"app.js\"></script>")
  string(FIND "${page}" "${part}" place)
  if(place EQUAL -1)
    message(FATAL_ERROR "${FOLDER}/index.html has no ${part}")
  endif()
endforeach()
string(REPLACE "<link rel=\"stylesheet\" href=\"style.css\">" "<style>${style}</style>" page "${page}")
string(REPLACE "<script type=\"module\" src=\"app.js\"></script>" "<script type=\"module\">${script}</script>" page "${page}")
foreach(text script style page)
  string(SHA256 ${text}_hash "${${text}}")
endforeach()

# The same bytes whenever it is built: the time in the gzip file's head becomes 0.
file(WRITE ${OUTPUT}.html "${page}")
file(ARCHIVE_CREATE OUTPUT ${OUTPUT}.gz PATHS ${OUTPUT}.html FORMAT raw COMPRESSION GZip COMPRESSION_LEVEL 9)
file(READ ${OUTPUT}.html html HEX)
file(READ ${OUTPUT}.gz gzipped HEX)
string(SUBSTRING ${gzipped} 16 -1 gzipped)
set(gzipped "1f8b080000000000${gzipped}")

foreach(name html gzipped)
  string(REGEX REPLACE "(..)" "0x\\1," bytes "${${name}}")
  string(APPEND arrays "constexpr unsigned char ${name}[] = {${bytes}0};\n")
endforeach()
file(WRITE ${OUTPUT} "#include \"serve/access.hpp\"

namespace ringsplat::serve {
namespace {

${arrays}
}  // namespace

const PageFile page_file{{reinterpret_cast<const char*>(html), sizeof html - 1},
                         {reinterpret_cast<const char*>(gzipped), sizeof gzipped - 1},
                         \"${script_hash}\", \"${style_hash}\", \"${page_hash}\"};

}  // namespace ringsplat::serve
")
