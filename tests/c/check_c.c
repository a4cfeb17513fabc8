/* What the C interface says of what is wrong, and that it can be used on. */
#include <ringsplat/ringsplat.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static void expect(int condition, const char* what) {
  if (condition) return;
  fprintf(stderr, "not so: %s; the message is: %s\n", what, ringsplat_message());
  exit(1);
}

static void refused(int status, const char* words) {
  expect(status == RINGSPLAT_INPUT_ERROR && strstr(ringsplat_message(), words) != NULL, words);
}

int main(int argc, char** argv) {
  const int32_t dims[3] = {12, 10, 8}, none[3] = {0, 10, 8}, first[3] = {0, 0, 0};
  unsigned char* values = calloc(12 * 10 * 8, 1);
  for (int k = 0; k < 12 * 10 * 8; ++k) values[k] = (unsigned char)(k % 251);
  ringsplat_session* session = NULL;
  expect(ringsplat_open(RINGSPLAT_ALONE, &session) == 0, "a session of this process alone");

  refused(ringsplat_set_grid(session, dims, "float16", NULL, NULL), "float16");
  refused(ringsplat_commit(session), "float16");
  refused(ringsplat_set_grid(session, none, "uint8", NULL, NULL), "dimensions 0 x 10 x 8");
  refused(ringsplat_commit(session), "dimensions 0 x 10 x 8");
  expect(ringsplat_set_grid(session, dims, "uint8", NULL, NULL) == 0, "a grid");
  refused(ringsplat_commit(session), "no block");
  refused(ringsplat_show(session, 1, 0), "nothing is served");
  expect(ringsplat_add_block(session, first, dims, values, NULL) == 0, "a block");
  expect(ringsplat_update_block(session, 7, values, NULL) == 0, "told by the next collective call");
  refused(ringsplat_commit(session), "no block 7");
  expect(ringsplat_commit(session) == 0, "a whole volume");

  refused(ringsplat_render(session, "--colour=red", argv[1]), "--colour");
  refused(ringsplat_render(session, "--tf=grey", "picture.xyz"), "picture.xyz");
  refused(ringsplat_serve(session, "", 0, 0), "share 0");
  refused(ringsplat_offer(session, "gain", NULL, 0, 1), "nothing is served");
  refused(ringsplat_commit(session), "nothing is served");
  expect(ringsplat_render(session, "--tf=grey --size=40", argv[1]) == 0, "a picture");
  refused(ringsplat_visualise(session), "nothing is served");
  ringsplat_close(session);
  ringsplat_close(NULL);
  refused(ringsplat_open_aside(RINGSPLAT_ALONE, 1, &session), "1 of 1 ranks cannot be set aside");
  free(values);
  return argc - 2;
}
