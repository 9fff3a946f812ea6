// Bakes beside the page: { bytes, options } comes in, { progress } and at last { baked, notes } or { error } go out.

import { load } from "./index.js";
import { packed } from "./errors.js";

self.onmessage = async ({ data: { bytes, options } }) => {
  try {
    const onProgress = (...progress) => self.postMessage({ progress });
    const avatar = await load(bytes, { ...options, onProgress, worker: false });
    const baked = avatar.save();
    self.postMessage({ baked, notes: avatar.notes }, [baked.buffer]);
  } catch (error) {
    self.postMessage({ error: packed(error) });
  }
};
