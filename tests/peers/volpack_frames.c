/* Renders the scene of scripts/study peers with VolPack (Lacroute and Levoy 1994).

     volpack_frames FOLDER FUNCTION phong|none X Y Z SPACING_X SPACING_Y SPACING_Z SIZE [PICTURES]

   Prints the seconds of each view's frame: shading table and rendering of the classified volume. PICTURES:
   also writes volpack-FUNCTION-SHADING-NNNN.pfm. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <volpack.h>

typedef struct {
  short normal; /* shading fields first */
  unsigned char density, gradient;
} Voxel;
enum { normal_field, density_field, gradient_field };

static const char *folder, *function_name, *shading;
static int dims[3], size, pictures;
static double spacing[3];
static vpContext* vpc;

static void die(const char* what) {
  fprintf(stderr, "volpack_frames: %s\n", what);
  exit(1);
}

static void ok(vpResult result) {
  if (result != VP_OK) die(vpGetErrorString(vpGetError(vpc)));
}

static FILE* open_in_folder(const char* name, const char* mode) {
  char path[4096];
  snprintf(path, sizeof path, "%s/%s", folder, name);
  FILE* file = fopen(path, mode);
  if (!file) die(path);
  return file;
}

static void* allocate(size_t bytes) {
  void* memory = malloc(bytes);
  if (!memory) die("out of memory");
  return memory;
}

static void load_volume(void) {
  const size_t count = (size_t)dims[0] * (size_t)dims[1] * (size_t)dims[2];
  unsigned char* values = allocate(count);
  Voxel *voxels = allocate(count * sizeof(Voxel)), *layout = voxels;
  FILE* file = open_in_folder("head.raw", "rb");
  if (fread(values, 1, count, file) != count) die("head.raw is too short");
  fclose(file);
  ok(vpSetVolumeSize(vpc, dims[0], dims[1], dims[2]));
  ok(vpSetVoxelSize(vpc, sizeof(Voxel), 3, 2, 1));
  ok(vpSetVoxelField(vpc, normal_field, sizeof(short), vpFieldOffset(layout, normal), VP_NORM_MAX));
  ok(vpSetVoxelField(vpc, density_field, 1, vpFieldOffset(layout, density), 255));
  ok(vpSetVoxelField(vpc, gradient_field, 1, vpFieldOffset(layout, gradient), VP_GRAD_MAX));
  ok(vpSetRawVoxels(vpc, voxels, count * sizeof(Voxel), sizeof(Voxel), dims[0] * (int)sizeof(Voxel),
                    dims[0] * dims[1] * (int)sizeof(Voxel)));
  ok(vpVolumeNormals(vpc, values, count, density_field, gradient_field, normal_field));
  free(values);
}

/* The run-length encoded volume is made once, as in VolPack's own programs. */
static void classify(void) {
  static float opacity[256];
  char name[256];
  snprintf(name, sizeof name, "%s.opacity", function_name);
  FILE* file = open_in_folder(name, "r");
  for (int k = 0; k < 256; ++k)
    if (fscanf(file, "%f", &opacity[k]) != 1) die("the opacities are too few");
  fclose(file);
  ok(vpSetClassifierTable(vpc, 0, density_field, opacity, sizeof opacity));
  ok(vpSetd(vpc, VP_MIN_VOXEL_OPACITY, 0.001));
  ok(vpSetd(vpc, VP_MAX_RAY_OPACITY, 1.0 - 1.0 / 512));
  ok(vpClassifyVolume(vpc));
}

static void set_material(void) {
  static float shade_table[VP_NORM_MAX + 1];
  const int lit = strcmp(shading, "phong") == 0;
  const double ambient = lit ? 0.25 : 1.0, diffuse = lit ? 0.75 : 0.0, specular = lit ? 0.25 : 0.0;
  ok(vpSetLookupShader(vpc, 1, 1, normal_field, shade_table, sizeof shade_table, 0, NULL, 0));
  ok(vpSetMaterial(vpc, VP_MATERIAL0, VP_AMBIENT, VP_BOTH_SIDES, ambient, ambient, ambient));
  ok(vpSetMaterial(vpc, VP_MATERIAL0, VP_DIFFUSE, VP_BOTH_SIDES, diffuse, diffuse, diffuse));
  ok(vpSetMaterial(vpc, VP_MATERIAL0, VP_SPECULAR, VP_BOTH_SIDES, specular, specular, specular));
  /* The highlight there is by the half vector, whose angle is half the mirrored ray's: about four times the
   * exponent. */
  ok(vpSetMaterial(vpc, VP_MATERIAL0, VP_SHINYNESS, VP_BOTH_SIDES, 4 * 24.0, 0, 0));
  ok(vpEnable(vpc, VP_LIGHT0, 1));
  ok(vpEnable(vpc, VP_LIGHT_BOTH_SIDES, 1));
}

/* ringsplat's camera (view/camera.cpp): rows right, up and to the viewer, the bounding sphere fits the
 * picture. */
static void turn(double azimuth, double elevation) {
  const double a = azimuth * M_PI / 180, e = elevation * M_PI / 180;
  const double ca = cos(a), sa = sin(a), ce = cos(e), se = sin(e);
  const double rows[3][3] = {{ca, sa, 0}, {-se * sa, se * ca, ce}, {ce * sa, -ce * ca, se}};
  const double light[3] = {-0.4, 0.6, 0.7};
  vpMatrix4 view = {{0}};
  int longest = 0;
  double radius = 0, world[3] = {0};
  for (int r = 0; r < 3; ++r) {
    longest = dims[r] > longest ? dims[r] : longest;
    radius += 0.25 * dims[r] * spacing[r] * dims[r] * spacing[r];
    for (int k = 0; k < 3; ++k) {
      view[r][k] = rows[r][k];
      world[k] += light[r] * rows[r][k];
    }
  }
  /* The shading table is right only while this matrix hardly scales. */
  const double unit = longest * cbrt(spacing[0] * spacing[1] * spacing[2]);
  radius = sqrt(radius) / unit;
  view[3][3] = 1;
  ok(vpCurrentMatrix(vpc, VP_MODEL));
  ok(vpIdentityMatrix(vpc));
  ok(vpSetLight(vpc, VP_LIGHT0, VP_DIRECTION, world[0], world[1], world[2]));
  /* The longest axis fills the unit cube and the others have the same steps; a voxel lies at its cell's lower
     corner and a pixel's ray at its lower left one. */
  const double cell[3] = {spacing[0] / unit, spacing[1] / unit, spacing[2] / unit};
  ok(vpTranslate(vpc, 0.5 * cell[0], 0.5 * cell[1], 0.5 * cell[2]));
  ok(vpScale(vpc, longest * cell[0], longest * cell[1], longest * cell[2]));
  ok(vpCurrentMatrix(vpc, VP_VIEW));
  ok(vpSetMatrix(vpc, view));
  ok(vpCurrentMatrix(vpc, VP_PROJECT));
  ok(vpIdentityMatrix(vpc));
  const double low = -radius + radius / size, high = radius + radius / size;
  ok(vpWindow(vpc, VP_PARALLEL, low, high, low, high, -radius, radius));
}

static double seconds(void) {
  struct timespec now;
  clock_gettime(CLOCK_MONOTONIC, &now);
  return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

static void write_pfm(const unsigned char* pixels, int number) {
  char name[256];
  snprintf(name, sizeof name, "volpack-%s-%s-%04d.pfm", function_name, shading, number);
  FILE* file = open_in_folder(name, "wb");
  fprintf(file, "PF\n%d %d\n-1.0\n", size, size);
  for (int p = 0; p < size * size; ++p) {
    const float v = (float)pixels[p] / 255;
    const float rgb[3] = {v, v, v};
    fwrite(rgb, sizeof rgb, 1, file);
  }
  if (fclose(file) != 0) die("a picture could not be written");
}

int main(int argc, char** argv) {
  if (argc < 11) die("see the head of volpack_frames.c");
  folder = argv[1], function_name = argv[2], shading = argv[3];
  for (int k = 0; k < 3; ++k) dims[k] = atoi(argv[4 + k]), spacing[k] = atof(argv[7 + k]);
  size = atoi(argv[10]), pictures = argc > 11;
  vpc = vpCreateContext();
  load_volume();
  classify();
  set_material();
  unsigned char* pixels = allocate((size_t)size * (size_t)size);
  ok(vpSetImage(vpc, pixels, size, size, size, VP_LUMINANCE));
  FILE* views = open_in_folder("views.txt", "r");
  double azimuth, elevation;
  for (int number = 0; fscanf(views, "%lf %lf", &azimuth, &elevation) == 2; ++number) {
    const double start = seconds();
    turn(azimuth, elevation);
    ok(vpShadeTable(vpc));
    ok(vpRenderClassifiedVolume(vpc));
    printf("%.9f\n", seconds() - start);
    if (pictures) write_pfm(pixels, number);
  }
  return 0;
}
