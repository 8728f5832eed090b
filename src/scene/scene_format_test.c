/* SPDX-License-Identifier: MIT */
/* Files and folders that are no glTF: what the message says, and that it is the only one. */
#include "scene/scene_format.h"
#include "tests/gltf_test_file.h"

#include <setjmp.h>
#include <stdarg.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cmocka.h>

static struct test_log lines;

static void test_other_formats_say_how_to_convert_them(void **state) {
    (void)state;
    static const struct {
        const char *name, *contents, *message; /* NULL: it is read as glTF */
    } files[] = {
        {"a/model.obj", "v 0 0 0\n", "a/model.obj: is a Wavefront OBJ file. Fanal reads glTF 2.0, as .gltf or .glb: convert it by 'assimp export a/model.obj a/model.glb' "
                                     "(Debian: assimp-utils), or with Blender (File > Export > glTF 2.0)\n"},
        {"MODEL.OBJ", "# made by hand\n", "MODEL.OBJ: is a Wavefront OBJ file."},
        {"m.ply", "ply\nformat ascii 1.0\n", "m.ply: is a PLY file."},
        {"points", "ply\r\nformat ascii 1.0\r\n", "points: is a PLY file. Fanal reads glTF 2.0, as .gltf or .glb: convert it by 'assimp export points points.glb'"},
        {"m.stl", "\x80\x80\x80", "m.stl: is an STL file."},
        {"m.bin", "solid cube\n", "m.bin: is an STL file."},
        {"m.fbx", "; FBX 7.4.0 project file\n", "m.fbx: is an FBX file."},
        {"m.dat", "Kaydara FBX Binary  ", "m.dat: is an FBX file."},
        {"m.usd", "\x01\x02", "m.usd: is a USD scene. Fanal reads glTF 2.0, as .gltf or .glb: convert it with Blender (File > Import, then File > Export > glTF 2.0)\n"},
        {"m", "#usda 1.0\n", "m: is a USD scene."},
        {"m", "PXR-USDC\1", "m: is a USD scene."},
        {"m.usdz", "PK\3\4\n", "m.usdz: is a USD scene."},
        {"m.blend", "BLENDER-v300", "m.blend: is a Blender file. Fanal reads glTF 2.0, as .gltf or .glb: convert it with Blender (File > Open, then"},
        {"m.3ds", "MM\x1f", "m.3ds: is a 3DS file."},
        {"m.dae", "<?xml version=\"1.0\"?>", "m.dae: is a COLLADA file."},
        {"m.zip", "PK\3\4\n", "m.zip: is a zip archive. Fanal reads glTF 2.0, as .gltf or .glb: unpack the archive and open the scene in it\n"},
        {"m.gltf", "PK\3\4\n", "m.gltf: is a zip archive."},
        {"m.obj", " \n{}", NULL},
        {"m.obj", "glTF\2", NULL},
        {"m.obj", "", NULL},
        {"m.gltf", "nonsense", NULL},
    };
    for (size_t i = 0; i < COUNT_OF(files); i++) {
        fnl_host host = test_host(&lines);
        const fnl_result result = scene_refuse_foreign(&host, files[i].name, files[i].contents, strlen(files[i].contents));
        assert_int_equal(result, files[i].message ? FNL_ERROR_UNSUPPORTED : FNL_OK);
        assert_int_equal(lines.count, files[i].message ? 1 : 0);
        if (files[i].message) assert_int_equal(strncmp(lines.text, files[i].message, strlen(files[i].message)), 0);
    }
    /* The same through the calls that load. */
    fnl_scene *scene;
    fnl_load_params params = fnl_load_params_default();
    params.data = "v 0 0 0\n";
    params.size = 8;
    fnl_host host = test_host(&lines);
    assert_int_equal(fnl_scene_load(&host, "model.obj", &params, &scene), FNL_ERROR_UNSUPPORTED);
    assert_null(scene);
    assert_int_equal(lines.count, 1);
}

static void write_file(const char *name) {
    FILE *file = fopen(name, "w");
    assert_non_null(file);
    fputs("{\"asset\": {\"version\": \"2.0\"}}", file);
    assert_int_equal(fclose(file), 0);
}

static void expect_folder(const char *message) {
    fnl_scene *scene;
    fnl_host host = test_host(&lines);
    assert_int_equal(fnl_scene_load(&host, "place", NULL, &scene), message ? FNL_ERROR_FILE : FNL_OK);
    assert_string_equal(lines.text, message ? message : "");
    fnl_scene_destroy(&scene);
}

static void test_a_folder_with_one_scene_opens_it(void **state) {
    (void)state;
    char folder[] = "/tmp/fanal-format-XXXXXX", path[4096];
    fnl_host host = test_host(&lines);
    assert_non_null(mkdtemp(folder));
    assert_int_equal(chdir(folder), 0);
    assert_int_equal(mkdir("place", 0777), 0);
    expect_folder("place: is a folder without a scene: it has no .gltf or .glb file\n");
    write_file("place/.hidden.gltf");
    write_file("place/picture.png");
    expect_folder("place: is a folder without a scene: it has no .gltf or .glb file\n");
    write_file("place/Chair.GLTF");
    expect_folder(NULL);
    assert_int_equal(scene_find_file(&host, "place", path, sizeof path), FNL_OK);
    assert_string_equal(path, "place/Chair.GLTF");
    assert_int_equal(scene_find_file(&host, "place/", path, sizeof path), FNL_OK);
    assert_string_equal(path, "place/Chair.GLTF");
    assert_int_equal(scene_find_file(&host, "place/picture.png", path, sizeof path), FNL_OK);
    assert_string_equal(path, "place/picture.png");
    assert_int_equal(scene_find_file(&host, "place", path, 16), FNL_ERROR_FILE);
    write_file("place/table.glb");
    expect_folder("place: is a folder with 2 scenes, Chair.GLTF, table.glb: name one of them\n");
    char name[32];
    for (int i = 0; i < 200; i++) {
        snprintf(name, sizeof name, "place/chair-%03d.glb", i);
        write_file(name);
    }
    test_host(&lines);
    assert_int_equal(scene_find_file(&host, "place", path, sizeof path), FNL_ERROR_FILE);
    assert_non_null(strstr(lines.text, "place: is a folder with 202 scenes, "));
    assert_non_null(strstr(lines.text, " more: name one of them\n"));
    for (int i = 0; i < 200; i++) {
        snprintf(name, sizeof name, "place/chair-%03d.glb", i);
        unlink(name);
    }
    static const char *const files[] = {"place/.hidden.gltf", "place/picture.png", "place/Chair.GLTF", "place/table.glb"};
    for (size_t i = 0; i < COUNT_OF(files); i++) unlink(files[i]);
    rmdir("place");
    assert_int_equal(chdir("/"), 0);
    rmdir(folder);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_other_formats_say_how_to_convert_them),
        cmocka_unit_test(test_a_folder_with_one_scene_opens_it),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
