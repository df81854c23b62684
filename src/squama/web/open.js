// A button that opens a file: its bytes go to the server in one message, which is bounded there too.
export default {
  props: { label: String, title: String, accept: String, largest: Number },
  emits: ["opened", "refused"],
  template: `
    <span>
      <button type="button" data-do="open" :title="title" @click="$refs.file.click()">{{ label }}</button>
      <input ref="file" type="file" hidden :accept="accept" :aria-label="label" @change="read" />
    </span>`,
  methods: {
    async read(event) {
      const file = event.target.files[0];
      if (!file) return;
      if (file.size > this.largest) {
        this.$emit("refused", file.size);
      } else {
        const bytes = new Uint8Array(await file.arrayBuffer());
        let text = "";
        for (let i = 0; i < bytes.length; i += 8192) text += String.fromCharCode(...bytes.subarray(i, i + 8192));
        this.$emit("opened", { name: file.name, data: btoa(text) });
      }
      // the same file may be opened again
      event.target.value = "";
    },
  },
};
