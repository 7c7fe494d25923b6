/*
 * Starts a page that is one file: unpacks its modules and its show, and hands the show to
 * offline.js. A classic script, written into the page after the element with the payload:
 *
 *   <body>
 *   <script type="text/plain" id="mgjax-payload" data-options="{}">BASE64</script>
 *   <script>this file</script>
 *
 * The payload is base64 of zlib's deflate of: the length of the next part (32-bit, little-endian);
 * modules as JSON in UTF-8, {"stage/offline.js": source, …}, in which every import names another of
 * these ("stage/draw/gl.js"); a packet of a show. `data-options` are the options of offline.js.
 */
(async () => {
  'use strict';
  const payload = document.getElementById('mgjax-payload');
  const root = document.createElement('div');
  payload.before(root);

  async function inflate(text) {
    const packed = Uint8Array.from(atob(text.trim()), (letter) => letter.charCodeAt(0));
    const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream('deflate'));
    return new Response(stream).arrayBuffer();
  }

  function offer(modules) {
    const imports = {};
    for (const [name, source] of Object.entries(modules)) {
      imports[name] = `data:text/javascript;charset=utf-8,${encodeURIComponent(source)}`;
    }
    const map = document.createElement('script');
    map.type = 'importmap';
    map.textContent = JSON.stringify({ imports });
    document.head.append(map);
  }

  try {
    const bytes = await inflate(payload.textContent);
    const size = new DataView(bytes).getUint32(0, true);
    offer(JSON.parse(new TextDecoder().decode(new Uint8Array(bytes, 4, size))));
    const { start } = await import('stage/offline.js');
    start(root, bytes.slice(4 + size), JSON.parse(payload.dataset.options || '{}'));
  } catch (error) {
    root.textContent = `This browser cannot play the motion: ${error.message}`;
  }
})();
